"""trimesh's `remesh.subdivide`: each triangle split in four where it lies, in NumPy; welded, float64, a call per level.

The surface is the coarse one, as that of `pattern`; normals are not made. `Trimesh.subdivide` calls the same function
and carries attributes along, which takes longer.

Source: PyPI package trimesh, trimesh.remesh.subdivide.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.simplifier import meshes, peer
from lodbench.harness.baselines.subdivision import Params, Peer, subdivision_system, wide

__all__ = ["Params", "SYSTEM"]


def _start(mesh: TriangleMesh, times: int) -> Callable[[], Any]:
    subdivide = peer("trimesh.remesh", "pip install trimesh").subdivide
    given = wide(mesh)

    def call() -> Any:
        points, faces = given
        for _ in range(times):
            points, faces = subdivide(points, faces)
        return points, faces

    return call


SYSTEM = subdivision_system(
    "trimesh_subdivide",
    "PyPI trimesh, trimesh.remesh.subdivide",
    Peer(_start, lambda output: meshes(*output), linear=True, any_mesh=True),
    {"linear_16": Params(16)},
)
