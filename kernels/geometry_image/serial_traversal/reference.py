"""The same surface as `quadtree_lod`'s, whatever the order of its rows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh


def in_order(mesh: TriangleMesh) -> NDArray[np.float32]:
    """Each triangle's corners, lowest first, and the triangles sorted: equal for equal surfaces. (m, 9) float32."""
    corners = mesh.positions[mesh.triangles]
    order = np.lexsort(mesh.positions.T)
    rank = np.empty(mesh.vertex_count, np.int64)
    # one rank for all vertices at one place; where two corners are there, the corner after them decides
    other = np.diff(mesh.positions[order], axis=0, prepend=np.nan) != 0
    rank[order] = np.cumsum(other.any(axis=1))
    own = rank[mesh.triangles]
    first = np.argmin(own * (mesh.vertex_count + 1) + np.roll(own, -1, axis=1), axis=1)[:, None]
    turned = np.take_along_axis(corners, ((first + np.arange(3)) % 3)[..., None], axis=1)
    rows = turned.reshape(-1, 9)
    return rows[np.lexsort(rows.T)]


def differing(mesh: TriangleMesh, expected: TriangleMesh) -> int:
    """Triangles of one surface that the other lacks."""
    one, other = in_order(mesh), in_order(expected)
    if one.shape != other.shape:
        return abs(len(one) - len(other)) or 1
    return int((one != other).any(axis=1).sum())
