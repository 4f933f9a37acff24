"""The pool of adaptive patterns: one for every three depths that a triangle's edges can have.

```
depths (i, j, k)   of the edges P1 P2, P2 P0, P0 P1; an edge of depth d has 2^d segments
pattern            the uniform lattice of the largest of them, where the vertices of a coarser edge are moved along it
                   to the nearest of its own, and triangles that collapse are left out ("lattice snap")
```
Vertices are numbers of the lattice of the pattern's own depth, in its order: those of edge P1 P2 come last.

Source: Boubekeur & Schlick 2007, Generic Adaptive Mesh Refinement, GPU Gems 3, chapter 5 (the pool, indexed by depths).
Which triangles a pattern has is left open there: lattice snap is a reconstruction.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from lodbench.datasets_gen.surfaces import Floats, Indices
from lodbench.kernels.refine.lattice import (
    lattice_rows,
    lattice_triangles,
    lattice_vertex_count,
    lattice_weights,
)

Integers = NDArray[np.int64]
PADDING = 16  # vertices past the last pattern's: a vector may begin at its last vertex
INSIDE = 3  # the move of what lies on no edge


def snapped(t: Integers, n: int, step: int) -> Integers:
    """Where the places t = 0 .. n along an edge go, of which it keeps every `step`-th: to the nearest.

    Halfway they go to the nearer end of the edge, and in its middle forwards: so fans at corners keep their turn.
    """
    low = t - t % step
    high = low + step
    twice = 2 * (t - low)
    forwards = (twice > step) | ((twice == step) & (low + high >= n))
    return np.where(t % step == 0, t, np.where(forwards, high, low))


def _number(a: Integers, b: Integers, n: int) -> Integers:
    """The lattice's vertex with integer weights (a, b, n - a - b) of P0, P1 and P2."""
    row = n - a
    return row * (row + 1) // 2 + (row - b)


def _weights(n: int) -> Integers:
    """Integer weights of P0, P1 and P2 of every vertex of the lattice, (vertices, 3)."""
    i, j = lattice_rows(n)
    return np.stack([n - i, i - j, j], axis=1)


def snap(weights: Integers, depths: tuple[int, int, int], depth: int) -> Integers:
    """Integer weights (m, 3), of 2^depth in all, after the moves along the edges of these depths."""
    n = 1 << depth
    moved = weights.copy()
    for edge, own in enumerate(depths):
        a, b = (edge + 1) % 3, (edge + 2) % 3  # counter-clockwise from corner a to corner b
        rows = weights[:, edge] == 0
        to = snapped(weights[rows, b], n, 1 << (depth - own))
        moved[rows, a], moved[rows, b] = n - to, to
    return moved


@dataclass(frozen=True, eq=False)
class Pattern:
    """One pattern.

    Attributes:
        depths: of its edges P1 P2, P2 P0 and P0 P1.
    """

    depths: tuple[int, int, int]

    @property
    def depth(self) -> int:
        """The largest depth: of the lattice."""
        return max(self.depths)

    @cached_property
    def _faces(self) -> Integers:
        """Triangles (m, 3), by numbers of the whole lattice."""
        n = 1 << self.depth
        moved = snap(_weights(n), self.depths, self.depth)
        faces = _number(moved[:, 0], moved[:, 1], n)[lattice_triangles(n)]
        a, b, c = faces.T
        return faces[(a != b) & (b != c) & (c != a)]

    @cached_property
    def used(self) -> Integers:
        """Numbers of the lattice's vertices that the pattern has, ascending."""
        return np.unique(self._faces)

    @property
    def triangles(self) -> Indices:
        """(m, 3) uint32 by place in `used`, turning like (P0, P1, P2)."""
        return np.searchsorted(self.used, self._faces).astype(np.uint32)

    @property
    def integer_weights(self) -> Integers:
        """Weights of P0, P1 and P2 of each vertex, (vertices, 3), of 2^depth in all."""
        return _weights(1 << self.depth)[self.used]

    @property
    def last_row(self) -> int:
        """Place of the first vertex of edge P1 P2; it and all after it are on that edge."""
        return len(self.used) - (1 << self.depths[0]) - 1

    def interpolation(self, depth: int) -> csr_array:
        """What takes values at its vertices to the lattice of a depth no less: (lattice vertices, vertices)."""
        corners = self.integer_weights[self.triangles] << (
            depth - self.depth
        )  # (m, corner, weight)
        solve = np.linalg.inv(
            corners.astype(np.float64)
        )  # weights of P0, P1, P2 to those of corners
        places = _weights(1 << depth)
        inside = np.full(len(places), -np.inf)
        holder = np.zeros(len(places), np.int64)
        for triangle, own in enumerate(solve):
            least = (places @ own).min(axis=1)
            better = least > inside
            inside[better], holder[better] = least[better], triangle
        shares = np.einsum("nj,njk->nk", places, solve[holder])
        rows = np.repeat(np.arange(len(places)), 3)
        columns = self.triangles[holder].ravel()
        shape = (len(places), len(self.used))
        return csr_array((shares.ravel(), (rows, columns)), shape)

    @property
    def moves(self) -> Indices:
        """What the finest level adds, (m, 4): a vertex, the two between which it arises, and the edge or `INSIDE`.

        Those of edges come first: what lies inside may arise between them. Where this level only begins, vertices
        in the middle of those two make the surface of the pattern whose depths are all one less than the largest.
        """
        n, weights = 1 << self.depth, self.integer_weights
        if not self.depth:
            return np.zeros((0, 4), np.uint32)
        found = []
        for edge, own in enumerate(self.depths):
            if own:
                a, b = (edge + 1) % 3, (edge + 2) % 3
                step = 1 << (self.depth - own)
                corners = (weights == n).any(axis=1)
                on = (weights[:, edge] == 0) & ~corners & (weights[:, b] // step % 2 == 1)
                child = weights[on]
                shift = np.zeros(3, np.int64)
                shift[a], shift[b] = step, -step
                found.append((child, child + shift, child - shift, edge))
        inner = weights[(weights > 0).all(axis=1) & (weights % 2 == 1).any(axis=1)]
        # two weights are odd: the vertices before and after along the edge that keeps the even one
        even = (weights_even := inner % 2 == 0).argmax(axis=1)
        assert (weights_even.sum(axis=1) == 1).all()
        shift = np.zeros_like(inner)
        rows = np.arange(len(inner))
        shift[rows, (even + 1) % 3], shift[rows, (even + 2) % 3] = 1, -1
        i, j, k = (min(own, self.depth - 1) for own in self.depths)
        parents = [2 * snap((inner + s * shift) // 2, (i, j, k), self.depth - 1) for s in (1, -1)]
        found.append((inner, *parents, INSIDE))
        return np.concatenate([self._places(n, *move) for move in found]).astype(np.uint32)

    def _places(
        self, n: int, child: Integers, one: Integers, other: Integers, kind: int
    ) -> Integers:
        """Rows of `moves`, of integer weights."""
        places = [
            np.searchsorted(self.used, _number(vertices[:, 0], vertices[:, 1], n))
            for vertices in (child, one, other)
        ]
        return np.stack([*places, np.full(len(child), kind)], axis=1)


def number(depths: tuple[int, int, int], finest: int) -> int:
    """A pattern's place in the pool of patterns up to depth `finest`."""
    i, j, k = depths
    return (i * (finest + 1) + j) * (finest + 1) + k


@dataclass(frozen=True, eq=False)
class Pool:
    """All patterns up to a depth, one after the other in arrays that the kernels read.

    Attributes:
        finest: the largest depth.
        weights: (2, vertices + padding) float32, planes of u and v.
        triangles: (triangles, 3) uint32, places in the pattern's own vertices.
        moves: (moves, 2) uint32, see `Pattern.moves`: two numbers of 16 bits each, the lower first.
        records: (patterns + 1, 4) uint32: where each pattern's vertices, triangles and moves begin, and the place of
            the first vertex on edge P1 P2; the last row has the ends.
    """

    finest: int
    weights: Floats
    triangles: Indices
    moves: NDArray[np.uint32]
    records: NDArray[np.uint32]

    @property
    def lattice_vertices(self) -> int:
        """Vertices of the lattice that all patterns share."""
        return lattice_vertex_count(1 << self.finest)

    @cached_property
    def vertex_counts(self) -> Integers:
        """Of each pattern."""
        return np.diff(self.records[:, 0].astype(np.int64))

    @cached_property
    def triangle_counts(self) -> Integers:
        """Of each pattern."""
        return np.diff(self.records[:, 1].astype(np.int64))


@cache
def pool(finest: int) -> Pool:
    """The pool of patterns up to this depth, made once: 0.1 s and 8 MB for depth 6, eight times as much for 7."""
    every = range(finest + 1)
    patterns = [Pattern((i, j, k)) for i in every for j in every for k in every]
    weights, triangles, moves, records = [], [], [], []
    at = np.zeros(3, np.int64)
    for pattern in patterns:
        weights.append(lattice_weights(1 << pattern.depth)[pattern.used, 1:].astype(np.float32))
        triangles.append(pattern.triangles)
        moves.append(pattern.moves)
        records.append((*at, pattern.last_row))
        at += (len(weights[-1]), len(triangles[-1]), len(moves[-1]))
    records.append((*at, 0))
    packed = np.concatenate(moves)
    padded = np.zeros((2, -(-int(at[0]) // 8) * 8 + PADDING), np.float32)
    padded[:, : at[0]] = np.concatenate(weights).T
    return Pool(
        finest,
        padded,
        np.concatenate(triangles),
        (packed[:, ::2] | packed[:, 1::2] << 16).astype(np.uint32),
        np.array(records, np.uint32),
    )
