"""NURBS surfaces as one writes them in NumPy: dense matrices of basis functions times control points, float32.

The matrices are made before the clock starts, for parameters are the same in every frame. Points come out as
planes of x, y and z, NumPy's faster form; the output is allocated beforehand.

Source: S(u, v) = N M N^T of Concheiro 2013, section 6.2, on NumPy.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lodbench.datasets_gen.nurbs_surface import NurbsModel, NurbsSurface
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.harness.baselines.nurbs import Params, Points, grid_subject
from lodbench.kernels.nurbs.grids import Grid
from lodbench.kernels.nurbs.reference import basis, homogeneous, surface_origin
from lodbench.kernels.opencl import Device

__all__ = ["Params", "SYSTEM"]


def _evaluator(surface: NurbsSurface, grid: Grid) -> Callable[[], Points]:
    along_u, along_v = (
        np.ascontiguousarray(basis(knots, degree, samples)[0], np.float32)
        for knots, degree, samples in (
            (surface.knots_u, surface.degree_u, grid.u),
            (surface.knots_v, surface.degree_v, grid.v),
        )
    )
    net = homogeneous(surface).transpose(2, 0, 1).astype(np.float32)
    net = np.ascontiguousarray(net if surface.rational else net[:3])
    out = np.zeros((len(net), grid.rows, grid.columns), np.float32)
    origin = surface_origin(surface)[:, None, None]

    def call() -> Points:
        if surface.rational:
            np.matmul(along_u, np.matmul(net, along_v.T), out=out)
            np.divide(out[:3], out[3:], out=out[:3])
            np.add(out[:3], origin, out=out[:3])
        else:  # the origin goes with the control points: basis functions sum to 1
            np.matmul(along_u, np.matmul(net + origin, along_v.T), out=out)
        return out[:3]

    return call


def prepare(device: Device, model: NurbsModel, params: Params) -> HostPrepared:
    """Basis functions and control points as matrices, outputs allocated."""
    return grid_subject(device, model, params, _evaluator, planes=True)


SYSTEM = host_system(
    "numpy_nurbs",
    "Concheiro 2013, section 6.2, on NumPy",
    prepare,
    {"level_4": Params(4), "level_7": Params(7)},
    takes=(NurbsModel,),
)
