"""NURBS surfaces by geomdl: a call of its surface with all parameters, pure Python; points alone.

Source: PyPI package geomdl (NURBS-Python).
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
    """Surfaces as the package has them: v fastest, homogeneous where they are rational.

    Raises:
        Unsupported: the package is not installed.
    """
    install = "pip install geomdl"
    plain, rational = peer("geomdl.BSpline", install), peer("geomdl.NURBS", install)

    def evaluator(surface: NurbsSurface, grid: Grid) -> Callable[[], Points]:
        # knots stay as they are: the package would bring them to 0..1 by a rounding
        made = (rational if surface.rational else plain).Surface(normalize_kv=False)
        made.degree_u, made.degree_v = surface.degree_u, surface.degree_v
        net = surface.points
        if surface.rational:
            weights = surface.weights[..., None]
            net = np.concatenate([net * weights, weights], axis=2)
        made.set_ctrlpts(net.reshape(-1, net.shape[2]).tolist(), *net.shape[:2])
        made.knotvector_u, made.knotvector_v = surface.knots_u.tolist(), surface.knots_v.tolist()
        u, v = numbers(surface.knots_u, grid.u), numbers(surface.knots_v, grid.v)
        where = [(a, b) for a in u.tolist() for b in v.tolist()]

        def call() -> Points:
            return np.array(made.evaluate_list(where)).reshape(grid.rows, grid.columns, 3)

        return call

    return grid_subject(device, model, params, evaluator)


SYSTEM = host_system("geomdl_nurbs", "geomdl", prepare, {"level_4": Params(4)}, takes=(NurbsModel,))
