"""The triangular refinement pattern: its vertices, its triangles, and which of them neighbours share.

```
row 0        0             vertex (i, j) is number i (i + 1) / 2 + j,  0 <= j <= i <= segments
row 1       1 2            w = (segments - i) / segments   weight of P0
row 2      3 4 5           u = (i - j) / segments          weight of P1
P1 .. P2  6 7 8 9          v = j / segments                weight of P2
```
"""

from __future__ import annotations

from typing import Annotated, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Floats, Indices, TriangleMesh
from lodbench.kernels.parameters import Range

Segments: TypeAlias = Annotated[int, Range(1, 4096)]
Amplitude: TypeAlias = Annotated[float, Range(-1, 1)]
Waves: TypeAlias = Annotated[float, Range(0, 1e4)]


def lattice_vertex_count(segments: int) -> int:
    """Vertices of the pattern: (n + 1)(n + 2) / 2."""
    return (segments + 1) * (segments + 2) // 2


def lattice_rows(segments: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Row i and place j in the row of every vertex, in order."""
    i = np.repeat(np.arange(segments + 1), np.arange(1, segments + 2))
    return i, np.arange(len(i)) - i * (i + 1) // 2


def lattice_weights(segments: int) -> NDArray[np.float64]:
    """Barycentric (w, u, v) of every vertex, (n, 3) float64, quotients of integers.

    Rounded to float32 they are the same from either side of an edge, and those of a pattern with half the
    segments are among them to the bit.

    Source: Boubekeur & Schlick 2005, section 3.2: a vertex's position is its parameter.
    """
    i, j = lattice_rows(segments)
    return np.stack([segments - i, i - j, j], axis=1) / segments


def lattice_triangles(segments: int) -> Indices:
    """The pattern's segments^2 triangles, (m, 3) uint32, row by row, turning like (P0, P1, P2)."""
    i, j = lattice_rows(segments - 1)
    here, below = i * (i + 1) // 2 + j, (i + 1) * (i + 2) // 2 + j
    pointing_up = np.stack([here, below, below + 1], axis=1)
    pointing_down = np.stack([here, below + 1, here + 1], axis=1)
    pairs = np.stack([pointing_up, pointing_down], axis=1).reshape(-1, 3)
    in_row = np.stack([np.ones(len(j), bool), j < i], axis=1).ravel()
    return pairs[in_row].astype(np.uint32)


def lattice_interpolation(
    segments: int, finer: int
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Where each vertex of a finer pattern lies on the triangles of one with `segments`: vertices and their weights.

    Args:
        segments: of the coarser pattern.
        finer: segments of the finer one, a multiple.

    Returns:
        Three vertices of the coarser pattern, and their weights, for each of the finer: (3, n) each.
    """
    step = finer // segments
    row, place = lattice_rows(finer)
    (i, down), (j, along) = np.divmod(row, step), np.divmod(place, step)
    above = along > down  # in the triangle that has its edge in the row above
    corners = np.stack(
        [
            np.stack([i, j]),
            np.stack([i + 1, j + 1]),
            np.stack([np.where(above, i, i + 1), np.where(above, j + 1, j)]),
        ]
    )
    shares = np.stack([np.maximum(down, along), np.minimum(down, along), np.abs(down - along)])
    shares[0] = step - shares[0]
    corners = np.where(shares[:, None] > 0, corners, 0)  # past the last row none has a share
    rows, places = corners[:, 0], corners[:, 1]
    return rows * (rows + 1) // 2 + places, shares / step


def lattice_sharing(triangles: Indices, segments: int) -> tuple[NDArray[np.uint32], int]:
    """Which refined vertices are one, by integers alone: (edge, place on it) and never by position.

    Args:
        triangles: of the coarse mesh, (m, 3).
        segments: of the pattern.

    Returns:
        The welded vertex of every instance's vertex, (m, lattice vertices) uint32, and how many there are: first the
        coarse vertices in use, then edge after edge, then interior after interior.
    """
    corners = np.asarray(triangles, np.int64)
    n, count = segments, len(corners)
    i, j = lattice_rows(n)
    welded = np.empty((count, len(i)), np.uint32)

    used, compact = np.unique(corners, return_inverse=True)
    welded[:, [0, len(i) - 1 - n, len(i) - 1]] = compact.reshape(-1, 3)
    total = len(used)

    ends = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2)  # P0 P1, P1 P2, P2 P0
    low, high = ends.min(axis=2), ends.max(axis=2)
    edges, edge = np.unique(low * (corners.max(initial=0) + 1) + high, return_inverse=True)
    edge = edge.reshape(-1, 3)
    forward = ends[:, :, 0] <= ends[:, :, 1]
    step = np.arange(1, n)
    row = np.arange(n + 1) * np.arange(1, n + 2) // 2
    places = (row[1:n], row[n] + step, (row + np.arange(n + 1))[1:n][::-1])
    for side, place in enumerate(places):
        along = np.where(forward[:, side, None], step, n - step)
        welded[:, place] = total + edge[:, side, None] * (n - 1) + along - 1
    total += len(edges) * (n - 1)

    inside = np.flatnonzero((j > 0) & (j < i) & (i < n))
    last = total + count * len(inside)
    welded[:, inside] = np.arange(total, last, dtype=np.uint32).reshape(count, len(inside))
    return welded, last


def vertex_total(triangle_count: int, segments: int) -> int:
    """Vertices of all instances.

    Raises:
        ValueError: more than 32-bit indices can name.
    """
    vertices = triangle_count * lattice_vertex_count(segments)
    if vertices > 2**32:
        raise ValueError(f"segments: expected at most 2**32 vertices in all, got {vertices:,}")
    return vertices


def refined_mesh(
    mesh: TriangleMesh, segments: int, positions: Floats, normals: Floats
) -> TriangleMesh:
    """The instances' points and normals, (m * lattice vertices, 3) each, as one mesh whose instances share nothing.

    What else `mesh` has (uvs, colours, tags) is interpolated along.

    Raises:
        ValueError: see `vertex_total`.
    """
    vertex_total(mesh.triangle_count, segments)
    vertices = lattice_vertex_count(segments)
    first = np.arange(mesh.triangle_count, dtype=np.uint32)[:, None, None] * np.uint32(vertices)
    triangles = (lattice_triangles(segments)[None] + first).reshape(-1, 3)
    weights = lattice_weights(segments).astype(np.float32)
    others = {
        name: np.matmul(weights, values[mesh.triangles]).reshape(-1, values.shape[1])
        for name in ("uvs", "colours", "tags")
        if (values := getattr(mesh, name)) is not None
    }
    return TriangleMesh(positions, triangles, normals, **others)


def welded_mesh(refined: TriangleMesh, triangles: Indices, segments: int) -> TriangleMesh:
    """`refined_mesh` with each shared vertex once; `triangles` are the coarse ones."""
    welded, count = lattice_sharing(triangles, segments)
    return joined_mesh(refined, welded.ravel(), count)


def joined_mesh(refined: TriangleMesh, welded: NDArray[np.uint32], count: int) -> TriangleMesh:
    """A mesh with the vertices that are one joined: the first of them stays.

    Args:
        refined: of n vertices.
        welded: which vertex each becomes, (n,).
        count: how many there are then.
    """
    first = np.empty(count, np.int64)
    first[welded[::-1]] = np.arange(len(welded))[::-1]
    attributes = {
        name: None if (values := getattr(refined, name)) is None else values[first]
        for name in ("normals", "uvs", "colours", "tags")
    }
    faces = welded[refined.triangles]
    return TriangleMesh(refined.positions[first], faces, **attributes)
