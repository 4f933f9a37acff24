"""Bezier patches as SciPy's B-splines with no inner knots, along u and then along v; points alone, float64.

Source: scipy.interpolate.BSpline.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from lodbench.datasets_gen.surfaces import BezierPatches, TriangleMesh
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.kernels.bezier.lattice import lattice_triangles, side_vertices
from lodbench.kernels.bezier.params import Level
from lodbench.kernels.bezier.tessellated import judged, vertex_total
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.parameters import Parameters
from lodbench.kernels.system import Check, Frame

__all__ = ["Params", "SYSTEM"]

KNOTS = np.repeat((0.0, 1.0), 4)


@dataclass(frozen=True)
class Params(Parameters):
    """`level`: of resolution, 0 to 10: a patch has 2^level segments along each side."""

    level: Level = 4


def prepare(device: Device, patches: BezierPatches, params: Params) -> HostPrepared:
    """Control points with u first, as the package takes them."""
    setup = Timeline()
    with setup.host("allocate"):
        count, side = len(patches.points), side_vertices(params.level)
        vertices = vertex_total(count, side * side)
        t = np.arange(side) / (side - 1)
        P = np.ascontiguousarray(patches.points.transpose(1, 0, 2, 3), np.float64)

    def call(frame: Frame) -> NDArray[np.float64]:
        if not count:
            return np.zeros((side, side, 0, 3))
        curves = BSpline(KNOTS, P, 3)(t)  # (u, patch, 4, 3)
        return BSpline(KNOTS, curves.transpose(2, 0, 1, 3), 3)(t)  # (v, u, patch, 3)

    def read(output: NDArray[np.float64]) -> list[TriangleMesh]:
        points = output.transpose(2, 1, 0, 3).reshape(-1, 3).astype(np.float32)
        first = np.arange(count)[:, None, None] * side * side
        triangles = (lattice_triangles(params.level)[None] + first).reshape(-1, 3)
        return [TriangleMesh(points, triangles)]

    def verdict(meshes: Any) -> Check:
        return judged(patches, params.level, meshes[0].positions, None, np.arange(side * side))

    made = HostPrepared(device, call, read, verdict, setup, input_bytes=P.nbytes)
    made.count = lambda output: {"patches": count, "vertices": vertices}
    return made


SYSTEM = host_system(
    "scipy_bspline",
    "scipy.interpolate.BSpline",
    prepare,
    {"level_4": Params(4), "level_7": Params(7)},
    takes=(BezierPatches,),
)
