"""Coarse versions of meshes, as people make them before they refine."""

from __future__ import annotations

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh


def coarse_version(mesh: TriangleMesh, count: int) -> TriangleMesh:
    """At most `count` triangles of the same shape, by fast-simplification; positions and triangles alone."""
    import fast_simplification

    if mesh.triangle_count <= count:
        return mesh
    points, faces = fast_simplification.simplify(
        mesh.positions, mesh.triangles.astype(np.int64), target_count=count
    )
    return TriangleMesh(points, faces, origin=mesh.origin)
