"""Taking cells apart in plain words: which vertices of the input stay one, and which triangles are left by that."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.links import reference as troubled
from lodbench.kernels.cluster.turned import NO_VERTEX

Group = list[int]


def groups(mesh: TriangleMesh, vertex_map: NDArray[np.uint32]) -> list[Group]:
    """The vertices that stay one, each group ascending: cells, eighths of cells, and single vertices.

    Args:
        mesh: the input.
        vertex_map: (n,) the clustering's vertex of each, 0xFFFFFFFF where no triangle has it.
    """
    there = vertex_map != NO_VERTEX
    cells = [np.flatnonzero(vertex_map == cell).tolist() for cell in np.unique(vertex_map[there])]
    found: list[Group] = [*cells, *([vertex] for vertex in np.flatnonzero(~there).tolist())]
    are_cells = set(range(len(cells)))
    _, corners = left(mesh, labels(mesh, found))
    corners = corners[(corners < len(cells)).all(axis=1)]  # first the clustered mesh by itself
    while True:
        bad = troubled(corners.astype(np.uint32), len(found))
        parted: list[Group] = []
        still: set[int] = set()
        for number, group in enumerate(found):
            if not bad[number]:
                still |= {len(parted)} if number in are_cells else set()
                parted.append(group)
            elif number in are_cells:
                parted += eighths(mesh, group)
            else:
                parted += [[vertex] for vertex in group]
        found, are_cells = parted, still
        corners = left(mesh, labels(mesh, found))[1]
        bad = troubled(corners.astype(np.uint32), len(found))
        if not any(bad[number] and len(group) > 1 for number, group in enumerate(found)):
            return found


def eighths(mesh: TriangleMesh, group: Group) -> list[Group]:
    """The group split by the middle of its box."""
    points = mesh.positions[group].astype(np.float64)
    side = (points > (points.min(axis=0) + points.max(axis=0)) / 2) @ np.array([1, 2, 4])
    return [np.array(group)[side == one].tolist() for one in np.unique(side)]


def labels(mesh: TriangleMesh, groups: list[Group]) -> NDArray[np.intp]:
    """The number of each vertex's group, (n,)."""
    found = np.zeros(mesh.vertex_count, np.intp)
    for number, group in enumerate(groups):
        found[group] = number
    return found


def left(mesh: TriangleMesh, labels: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The triangles whose corners have three labels, (k,), and these, (k, 3)."""
    corners = labels[mesh.triangles].reshape(-1, 3)
    a, b, c = corners.T
    rows = np.flatnonzero((a != b) & (b != c) & (c != a))
    return rows, corners[rows]
