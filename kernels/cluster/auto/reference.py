"""How flat a mesh is, vertex by vertex."""

from __future__ import annotations

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh


def flat_share(mesh: TriangleMesh, even: float, step: int = 1) -> float:
    """The share of every `step`-th vertex with area around it whose triangles' normals all point the same way."""
    found: list[bool] = []
    points = mesh.positions.astype(np.float64)
    for vertex in range(0, mesh.vertex_count, step):
        rows = mesh.triangles[(mesh.triangles == vertex).any(axis=1)]
        normals = [np.cross(points[b] - points[a], points[c] - points[a]) for a, b, c in rows]
        area = sum(float(np.linalg.norm(normal)) for normal in normals)
        if area > 0:
            found.append(float(np.linalg.norm(np.sum(normals, axis=0))) >= (1 - even) * area)
    return float(np.mean(found)) if found else 0.0
