"""Coarse versions of meshes, as people make them before they refine."""

from __future__ import annotations

from typing import Any

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh


def coarse_version(mesh: TriangleMesh, count: int) -> TriangleMesh:
    """At most `count` triangles of the same shape, by fast-simplification; positions and triangles alone."""
    import fast_simplification

    if mesh.triangle_count <= count:
        return mesh
    faces: Any = mesh.triangles.astype(np.int64)
    made = fast_simplification.simplify(mesh.positions, faces, target_count=count)  # pyright: ignore[reportArgumentType]
    return TriangleMesh(made[0], made[1], origin=mesh.origin)
