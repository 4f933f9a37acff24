"""Triangles of a clustered mesh that say nothing of the surface: turned over, or the same as one before."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh

NO_VERTEX = np.uint32(0xFFFFFFFF)
GONE, SURVIVES, TURNED = range(3)
"""What becomes of an input triangle."""
COUNTED = ("duplicate_triangles", "flipped_triangles")


def counted(
    mesh: TriangleMesh, simplified: TriangleMesh, vertex_map: NDArray[np.uint32], distinct: bool
) -> dict[str, int]:
    """The counters `COUNTED` of the output.

    `duplicate_triangles` have the vertices of one before them, whichever way they face; `flipped_triangles` have a
    normal against that of the input triangle they come from.

    Args:
        mesh: the input.
        simplified: the output.
        vertex_map: (n,) output vertex of each input vertex, 0xFFFFFFFF where there is none.
        distinct: were duplicates removed?
    """
    found = fates(mesh, simplified, vertex_map)
    if distinct:  # else each that survives is in the output: quicker than finding the rows
        found = found[sources(found, mesh, simplified, vertex_map, distinct)]
    return {
        "duplicate_triangles": duplicates(simplified.triangles, simplified.vertex_count),
        "flipped_triangles": int(np.count_nonzero(found == TURNED)),
    }


def sources(
    found: NDArray[np.uint8],
    mesh: TriangleMesh,
    simplified: TriangleMesh,
    vertex_map: NDArray[np.uint32],
    distinct: bool,
    remove_flipped: bool = False,
) -> NDArray[np.intp]:
    """The input triangle of each output triangle, ascending; see `counted`.

    Args:
        found: the input triangles' `fates`.
        mesh, simplified, vertex_map, distinct: as for `counted`.
        remove_flipped: leave out those that are turned over, before a duplicate is removed for their sake.
    """
    rows = np.flatnonzero(found == SURVIVES if remove_flipped else found)
    if distinct:
        triangles = vertex_map[mesh.triangles[rows]].reshape(-1, 3)
        rows = rows[first_of_each(triangles, simplified.vertex_count)]
    return rows


def fates(
    mesh: TriangleMesh, simplified: TriangleMesh, vertex_map: NDArray[np.uint32]
) -> NDArray[np.uint8]:
    """What becomes of each input triangle, (m,), by the map to the output's vertices."""
    rows = vertex_map[mesh.triangles].reshape(-1, 3)
    a, b, c = rows.T
    found = ((a != b) & (b != c) & (c != a) & (rows != NO_VERTEX).all(axis=1)).astype(np.uint8)
    kept = np.flatnonzero(found)
    before = _normals(mesh.positions, mesh.triangles[kept])
    after = _normals(simplified.positions, rows[kept])
    found[kept[(before * after).sum(axis=1) < 0]] = TURNED
    return found


def turned_over(mesh: TriangleMesh, simplified: TriangleMesh, rows: NDArray[np.intp]) -> int:
    """How many triangles of the output have a normal against that of the input triangle that they come from, `rows`."""
    before = _normals(mesh.positions, mesh.triangles[rows])
    after = _normals(simplified.positions, simplified.triangles)
    return int(np.count_nonzero((before * after).sum(axis=1) < 0))


def _normals(points: NDArray[np.floating], triangles: NDArray[np.integer]) -> NDArray[np.float64]:
    a, b, c = (points[triangles[:, corner]].astype(np.float64) for corner in range(3))
    return np.cross(b - a, c - a)


def keys(triangles: NDArray[np.integer], vertex_count: int) -> NDArray[np.uint64]:
    """A number for each triangle, (m,), the same for those of the same three vertices, whichever way they face."""
    a, b, c = (np.ascontiguousarray(k) for k in triangles.T.astype(np.uint64))
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    middle, count = a + b + c - low - high, np.uint64(max(vertex_count, 1))
    pairs = low * count + middle
    if vertex_count > 2_600_000:  # whose third power 64 bits do not hold
        pairs = np.unique(pairs, return_inverse=True)[1].astype(np.uint64)
    return pairs * count + high


def duplicates(triangles: NDArray[np.integer], vertex_count: int) -> int:
    """Triangles, (m, 3), with the vertices of another one before them."""
    found = np.sort(keys(triangles, vertex_count))
    return int(np.count_nonzero(found[1:] == found[:-1]))


def first_of_each(triangles: NDArray[np.integer], vertex_count: int) -> NDArray[np.intp]:
    """Rows of triangles, (m, 3), without those that `duplicates` counts, ascending."""
    return np.sort(np.unique(keys(triangles, vertex_count), return_index=True)[1])


def with_triangles(
    mesh: TriangleMesh, vertex_map: NDArray[np.uint32], triangles: NDArray[np.uint32]
) -> tuple[TriangleMesh, NDArray[np.uint32]]:
    """The mesh with some of its triangles and the vertices that they use, in order, and the map to these."""
    used = np.zeros(mesh.vertex_count, bool)
    used[triangles.ravel()] = True
    number = np.full(mesh.vertex_count + 1, NO_VERTEX)
    number[:-1][used] = np.arange(np.count_nonzero(used), dtype=np.uint32)
    kept = replace(mesh, positions=mesh.positions[used], triangles=number[triangles])
    return kept, number[np.minimum(vertex_map, np.uint32(mesh.vertex_count))]
