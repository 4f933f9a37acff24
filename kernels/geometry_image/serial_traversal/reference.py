"""The same surface as `quadtree_lod`'s, whatever the order of its rows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh


def in_order(mesh: TriangleMesh) -> NDArray[np.float32]:
    """Each triangle's corners, lowest first, and the triangles sorted: equal for equal surfaces. (m, 9) float32."""
    corners = mesh.positions[mesh.triangles]
    rank = np.empty(mesh.vertex_count, np.int64)
    rank[np.lexsort(mesh.positions.T)] = np.arange(mesh.vertex_count)
    first = np.argmin(rank[mesh.triangles], axis=1)[:, None]
    turned = np.take_along_axis(corners, ((first + np.arange(3)) % 3)[..., None], axis=1)
    rows = turned.reshape(-1, 9)
    return rows[np.lexsort(rows.T)]


def differing(mesh: TriangleMesh, expected: TriangleMesh) -> int:
    """Triangles of one surface that the other lacks."""
    one, other = in_order(mesh), in_order(expected)
    if one.shape != other.shape:
        return abs(len(one) - len(other)) or 1
    return int((one != other).any(axis=1).sum())
