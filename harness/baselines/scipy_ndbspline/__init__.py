"""NURBS surfaces as SciPy's tensor-product B-splines, a point at a time, float64; points alone.

Source: scipy.interpolate.NdBSpline.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.interpolate import NdBSpline

from lodbench.datasets_gen.nurbs_surface import NurbsModel, NurbsSurface
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.harness.baselines.nurbs import Params, Points, grid_subject
from lodbench.kernels.nurbs.grids import Grid
from lodbench.kernels.nurbs.samples import numbers
from lodbench.kernels.opencl import Device

__all__ = ["Params", "SYSTEM"]


def _evaluator(surface: NurbsSurface, grid: Grid) -> Callable[[], Points]:
    net = surface.points
    if surface.rational:
        weights = surface.weights[..., None]
        net = np.concatenate([net * weights, weights], axis=2)
    knots, degrees = (surface.knots_u, surface.knots_v), (surface.degree_u, surface.degree_v)
    spline = NdBSpline(knots, net, degrees)
    places = [numbers(k, s) for k, s in zip(knots, (grid.u, grid.v), strict=True)]
    where = np.stack(np.meshgrid(*places, indexing="ij"), axis=-1)

    def call() -> Points:
        found = spline(where)
        return found[..., :3] / found[..., 3:] if surface.rational else found

    return call


def prepare(device: Device, model: NurbsModel, params: Params) -> HostPrepared:
    """Splines and a grid of parameters for each surface."""
    return grid_subject(device, model, params, _evaluator)


SYSTEM = host_system(
    "scipy_ndbspline",
    "scipy.interpolate.NdBSpline",
    prepare,
    {"level_4": Params(4)},
    takes=(NurbsModel,),
)
