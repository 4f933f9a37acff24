"""NURBS surfaces by splipy: a call of its Surface with all parameters, float64; points alone.

Source: PyPI package splipy.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lodbench.datasets_gen.nurbs_surface import NurbsModel, NurbsSurface
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.harness.baselines.nurbs import Params, Points, grid_subject
from lodbench.harness.baselines.simplifier import peer
from lodbench.kernels.nurbs.grids import Grid
from lodbench.kernels.nurbs.samples import numbers
from lodbench.kernels.opencl import Device

__all__ = ["Params", "SYSTEM"]


def prepare(device: Device, model: NurbsModel, params: Params) -> HostPrepared:
    """Surfaces as the package has them: u fastest, homogeneous.

    Raises:
        Unsupported: the package is not installed.
    """
    package = peer("splipy", "pip install splipy")

    def evaluator(surface: NurbsSurface, grid: Grid) -> Callable[[], Points]:
        sides = (surface.degree_u, surface.knots_u), (surface.degree_v, surface.knots_v)
        bases = [package.BSplineBasis(degree + 1, knots) for degree, knots in sides]
        net = surface.points
        if surface.rational:
            weights = surface.weights[..., None]
            net = np.concatenate([net * weights, weights], axis=2)
        rows = net.transpose(1, 0, 2).reshape(-1, net.shape[2])
        made = package.Surface(*bases, rows, surface.rational, raw=False)
        u, v = numbers(surface.knots_u, grid.u), numbers(surface.knots_v, grid.v)
        return lambda: made(u, v)

    return grid_subject(device, model, params, evaluator)


SYSTEM = host_system(
    "splipy_nurbs",
    "splipy",
    prepare,
    {"level_4": Params(4), "level_7": Params(7)},
    takes=(NurbsModel,),
)
