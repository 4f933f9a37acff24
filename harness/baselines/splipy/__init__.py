"""Bezier patches as splipy's surfaces, one after the other, each on the whole grid; points alone, float64.

Source: PyPI package splipy, Surface.evaluate.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import BezierPatches, TriangleMesh
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.harness.baselines.simplifier import peer
from lodbench.kernels.bezier.lattice import lattice_triangles, side_vertices
from lodbench.kernels.bezier.params import Level
from lodbench.kernels.bezier.tessellated import judged, vertex_total
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.parameters import Parameters
from lodbench.kernels.system import Check, Frame

__all__ = ["Params", "SYSTEM"]

INSTALL = "pip install splipy"


@dataclass(frozen=True)
class Params(Parameters):
    """`level`: of resolution, 0 to 10: a patch has 2^level segments along each side."""

    level: Level = 4


def prepare(device: Device, patches: BezierPatches, params: Params) -> HostPrepared:
    """A surface of the package for each patch.

    Raises:
        Unsupported: the package is not installed.
    """
    package = peer("splipy", INSTALL)
    setup = Timeline()
    with setup.host("allocate"):
        count, side = len(patches.points), side_vertices(params.level)
        vertices = vertex_total(count, side * side)
        t = np.arange(side) / (side - 1)
        basis = package.BSplineBasis(4)
        surfaces = [
            package.Surface(basis, basis, P, raw=True) for P in patches.points.astype(np.float64)
        ]

    def call(frame: Frame) -> list[NDArray[np.float64]]:
        return [surface.evaluate(t, t) for surface in surfaces]

    def read(output: list[NDArray[np.float64]]) -> list[TriangleMesh]:
        points = np.reshape(output, (-1, 3)).astype(np.float32)
        first = np.arange(count)[:, None, None] * side * side
        triangles = (lattice_triangles(params.level)[None] + first).reshape(-1, 3)
        return [TriangleMesh(points, triangles)]

    def verdict(meshes: Any) -> Check:
        return judged(patches, params.level, meshes[0].positions, None, np.arange(side * side))

    made = HostPrepared(device, call, read, verdict, setup, input_bytes=patches.points.nbytes)
    made.count = lambda output: {"patches": count, "vertices": vertices}
    return made


SYSTEM = host_system(
    "splipy",
    "PyPI package splipy, Surface.evaluate",
    prepare,
    {"level_4": Params(4), "level_7": Params(7)},
    takes=(BezierPatches,),
)
