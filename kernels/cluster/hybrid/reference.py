"""Taking cells apart in plain words: which triangles are left, by the input's vertices joined as far as they may be."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.links import reference as troubled
from lodbench.kernels.cluster.turned import NO_VERTEX


def labels(mesh: TriangleMesh, vertex_map: NDArray[np.uint32]) -> NDArray[np.intp]:
    """A label for each vertex, (n,): its output vertex, or one past these where it stays by itself.

    Args:
        mesh: the input.
        vertex_map: (n,) the clustering's vertex of each, 0xFFFFFFFF where no triangle has it.
    """
    there = vertex_map != NO_VERTEX
    cells = int(vertex_map[there].max()) + 1 if there.any() else 0
    found = np.where(there, vertex_map.astype(np.intp), cells)
    corners = left(mesh, found)[1]
    corners = corners[(corners < cells).all(axis=1)]  # first the clustered mesh by itself
    while True:
        bad = troubled(corners.astype(np.uint32), int(found.max(initial=0)) + 1)
        there &= ~bad[found]
        found = vertex_map.astype(np.intp)
        found[~there] = cells + np.arange(np.count_nonzero(~there))
        corners = left(mesh, found)[1]
        if not (
            there & troubled(corners.astype(np.uint32), int(found.max(initial=0)) + 1)[found]
        ).any():
            return found


def left(mesh: TriangleMesh, labels: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The triangles whose corners have three labels, (k,), and these, (k, 3)."""
    corners = labels[mesh.triangles].reshape(-1, 3)
    a, b, c = corners.T
    rows = np.flatnonzero((a != b) & (b != c) & (c != a))
    return rows, corners[rows]
