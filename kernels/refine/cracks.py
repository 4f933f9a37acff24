"""Where a refined surface may part: edges of the coarse mesh whose two sides have normals of their own."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh


def _numbered(*columns: NDArray[np.float32]) -> NDArray[np.int64]:
    """The number of each row's value among all that there are, (n,)."""
    rows = np.ascontiguousarray(np.concatenate(columns, axis=1) + np.float32(0))
    words = rows.view(np.dtype((np.void, rows.dtype.itemsize * rows.shape[1]))).ravel()
    return np.unique(words, return_inverse=True)[1].reshape(-1).astype(np.int64)


def split_edges(mesh: TriangleMesh) -> int:
    """How many edges two triangles share by the place of their ends, but not by their normals there.

    A surface that leaves its flat triangles by these normals, curved or displaced, opens a crack along each of them;
    along all others neighbours agree to the bit.
    """
    if not mesh.triangle_count:
        return 0
    place = _numbered(mesh.positions)
    if int(place.max()) + 1 == mesh.vertex_count:
        return 0  # no two vertices at one place
    normals = np.asarray(mesh.normals, np.float32).reshape(-1, 3)
    vertex = _numbered(mesh.positions, normals)
    ends = np.stack([mesh.triangles, np.roll(mesh.triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    keys = [np.sort(number[ends], axis=1) @ (mesh.vertex_count, 1) for number in (place, vertex)]
    edges = place[ends[:, 0]] != place[ends[:, 1]]
    both = np.unique(np.stack(keys, axis=1)[edges], axis=0)
    _, sides = np.unique(both[:, 0], return_counts=True)
    return int((sides > 1).sum())
