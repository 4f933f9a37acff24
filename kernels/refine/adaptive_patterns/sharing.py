"""Adaptive triangles read back: which vertices are one, by integers alone, and what else a mesh has, interpolated."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from lodbench.datasets_gen.surfaces import Indices, TriangleMesh
from lodbench.kernels.refine.adaptive_patterns.pool import Integers, Pattern


@cache
def _pattern(place: int, finest: int) -> Pattern:
    """A pattern of the pool, made once."""
    i, rest = divmod(place, (finest + 1) ** 2)
    return Pattern((i, *divmod(rest, finest + 1)))


def in_patterns(
    numbers: NDArray[np.uint32], offsets: NDArray[np.uint32], finest: int
) -> Iterator[tuple[Pattern, Integers, Integers]]:
    """Each pattern in use, the coarse triangles that take it, (k,), and where their vertices are, (k, vertices).

    Args:
        numbers: (m,) of each coarse triangle's pattern in the pool.
        offsets: (m,) where its vertices begin.
        finest: depth of the pool.
    """
    order = np.argsort(numbers, kind="stable")
    used, first = np.unique(numbers[order], return_index=True)
    ends = [*first[1:], len(order)]
    for place, begin, end in zip(used, first, ends, strict=False):
        pattern, rows = _pattern(int(place), finest), order[begin:end]
        yield pattern, rows, offsets[rows, None].astype(np.int64) + np.arange(len(pattern.used))


def sharing(
    triangles: Indices, numbers: NDArray[np.uint32], offsets: NDArray[np.uint32], finest: int
) -> tuple[NDArray[np.uint32], int]:
    """Which vertices are one, by (edge, place on it) and never by position.

    Args:
        triangles: of the coarse mesh, (m, 3).
        numbers: of each one's pattern, (m,).
        offsets: where each one's vertices begin, (m,).
        finest: depth of the pool.

    Returns:
        The welded vertex of every vertex, (vertices,) uint32, and how many there are: first the coarse vertices in use.
    """
    corners = triangles.astype(np.int64)
    most, n = int(corners.max(initial=0)) + 1, 1 << finest
    ends = np.stack([np.roll(corners, -1, axis=1), np.roll(corners, -2, axis=1)], axis=2)
    low, high = ends.min(axis=2), ends.max(axis=2)  # of the edges P1 P2, P2 P0 and P0 P1
    edges, edge = np.unique(low * most + high, return_inverse=True)
    edge = edge.reshape(-1, 3)
    inside = most + len(edges) * n
    parts = []
    for pattern, rows, slots in in_patterns(numbers, offsets, finest):
        weights = pattern.integer_weights << (finest - pattern.depth)
        keys = inside + slots  # a number that no other has
        for side in range(3):
            on = np.flatnonzero(weights[:, side] == 0)
            a, b = (side + 1) % 3, (side + 2) % 3
            forward = (corners[rows, a] < corners[rows, b])[:, None]
            along = np.where(forward, weights[on, b], weights[on, a])
            keys[:, on] = most + edge[rows, side, None] * n + along
        for corner in range(3):
            keys[:, np.flatnonzero(weights[:, corner] == n)] = corners[rows, corner, None]
        parts.append((slots.ravel(), keys.ravel()))
    if not parts:
        return np.zeros(0, np.uint32), 0
    keys = np.empty(sum(len(slots) for slots, _ in parts), np.int64)
    for slots, found in parts:
        keys[slots] = found
    every, welded = np.unique(keys, return_inverse=True)
    return welded.reshape(-1).astype(np.uint32), len(every)


def interpolated(
    mesh: TriangleMesh, numbers: NDArray[np.uint32], offsets: NDArray[np.uint32], finest: int
) -> dict[str, NDArray[np.float32]]:
    """Texture coordinates, colours and tags of the refined vertices, by name, where the mesh has them."""
    given = {n: v for n in ("uvs", "colours", "tags") if (v := getattr(mesh, n)) is not None}
    parts = list(in_patterns(numbers, offsets, finest)) if given else []
    count = sum(slots.size for _, _, slots in parts)
    made = {name: np.empty((count, v.shape[1]), np.float32) for name, v in given.items()}
    for pattern, rows, slots in parts:
        weights = (pattern.integer_weights / (1 << pattern.depth)).astype(np.float32)
        for name, values in given.items():
            made[name][slots] = np.matmul(weights, values[mesh.triangles[rows]])
    return made


@cache
def to_lattice(pattern: Pattern, finest: int) -> csr_array:
    """See `Pattern.interpolation`; kept, since a path of frames uses the same patterns again and again."""
    return pattern.interpolation(finest)
