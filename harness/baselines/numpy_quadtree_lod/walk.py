"""Choosing the nodes and making their triangles, as numpy does it fast: whole levels, strided views, 32-bit values.

The output is that of `quadtree_lod.reference`, vertex for vertex and triangle for triangle.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Floats, GeometryImage, Indices
from lodbench.kernels.geometry_image.parameterisation.octahedron import canonical
from lodbench.kernels.geometry_image.quadtree_lod.fit import anti_diagonal
from lodbench.kernels.geometry_image.quadtree_lod.reference import packed_slice

Mask = NDArray[np.bool_]
Rows = NDArray[np.intp]


class Drawn(NamedTuple):
    """positions, normals (n, 3) float32 and triangles (m, 3) uint32."""

    positions: Floats
    normals: Floats
    triangles: Indices


class _Fans(NamedTuple):
    """A level's nodes with a finer neighbour: their samples in the middle and around, node after node."""

    nodes: Mask
    counts: Rows  # of samples around each
    middle: Rows
    around: Rows


class Walk:
    """An image with the float32 errors of its nodes, per depth, 0 to n; what no threshold changes is made here."""

    def __init__(self, image: GeometryImage, errors: list[NDArray[np.float32]]) -> None:
        n = self._n = len(errors) - 1
        side = self._side = (1 << n) + 1
        self._errors = errors
        self._positions = image.positions.reshape(-1, 3)
        self._normals = image.normals.reshape(-1, 3)
        own = canonical(n).ravel()
        self._border = np.flatnonzero(own != np.arange(side * side))
        self._first = own[self._border]
        self._anti = [anti_diagonal(depth) for depth in range(n + 1)]
        self._rings = []
        for depth in range(n + 1):
            size = 1 << (n - depth)
            step, zero, full = np.arange(size), np.zeros(size, int), np.full(size, size)
            rows = np.concatenate([zero, step, full, size - step])
            columns = np.concatenate([step, full, size - step, zero])
            self._rings.append(rows * side + columns)

    def __call__(self, threshold: np.float32) -> Drawn:
        """The surface whose drawn nodes have errors below `threshold`, as far as there are such."""
        n, side = self._n, self._side
        drawn = self._choose(threshold)
        corners = self._corners(drawn)
        split = self._split(corners)
        counts = np.zeros((3 << (n - 1), side - 1), np.uint32)  # triangles, in the packed texture
        used = corners.copy()
        fans = []
        for depth in range(1, n + 1):
            packed = counts[packed_slice(depth, n)]
            packed[drawn[depth] & ~split[depth]] = 2
            found = self._fans(depth, drawn[depth] & split[depth], corners)
            packed[found.nodes] = found.counts
            used.ravel()[found.middle] = True
            fans.append(found)
        used.ravel()[self._border] = False
        ranks = np.cumsum(used, dtype=np.uint32).reshape(side, side) - np.uint32(1)
        ranks.ravel()[self._border] = ranks.ravel()[self._first]
        ends = np.cumsum(counts, dtype=np.uint32).reshape(counts.shape)
        triangles = np.empty((int(ends[-1, -1]), 3), np.uint32)
        starts = ends - counts
        for depth, found in enumerate(fans, start=1):
            first = starts[packed_slice(depth, n)]
            self._pairs(depth, drawn[depth] & ~split[depth], first, ranks, triangles)
            _emit_fans(found, first, ranks, triangles)
        mask = used.ravel()
        return Drawn(self._positions[mask], self._normals[mask], triangles)

    def _choose(self, threshold: np.float32) -> list[Mask]:
        """Per depth, which nodes are fine enough while none above is; leaves are, the root is not."""
        coarse = np.ones((1, 1), bool)
        drawn = [np.zeros((1, 1), bool)]
        for error in self._errors[1:-1]:
            above = coarse.repeat(2, axis=0).repeat(2, axis=1)
            fine = error < threshold
            drawn.append(above & fine)
            coarse = above & ~fine
        drawn.append(coarse.repeat(2, axis=0).repeat(2, axis=1))
        return drawn

    def _corners(self, drawn: list[Mask]) -> Mask:
        """Which samples are corners of drawn nodes, seam duplicates alike: (side, side)."""
        corners = np.zeros((self._side, self._side), bool)
        for depth, nodes in enumerate(drawn):
            step = 1 << (self._n - depth)
            grid = corners[::step, ::step]
            for part in (grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]):
                part |= nodes
        flat = corners.ravel()
        flat[self._first[flat[self._border]]] = True
        flat[self._border] = flat[self._first]
        return corners

    def _split(self, corners: Mask) -> list[Mask]:
        """Per depth, which nodes have a corner of another within a side: (2^d, 2^d)."""
        leaves = 1 << self._n
        found = [np.zeros((leaves, leaves), bool)]
        across, down = np.zeros((leaves + 1, leaves), bool), np.zeros((leaves, leaves + 1), bool)
        for depth in reversed(range(self._n)):
            step = 1 << (self._n - depth)
            half = step // 2
            across = across[::2, ::2] | across[::2, 1::2] | corners[::step, half::step]
            down = down[::2, ::2] | down[1::2, ::2] | corners[half::step, ::step]
            found.append(across[:-1] | across[1:] | down[:, :-1] | down[:, 1:])
        return found[::-1]

    def _fans(self, depth: int, nodes: Mask, corners: Mask) -> _Fans:
        size = 1 << (self._n - depth)
        y, x = np.nonzero(nodes)
        first = (y * self._side + x) * size
        ring = first[:, None] + self._rings[depth]
        at = corners.ravel()[ring]
        middle = first + (self._side + 1) * (size // 2)
        return _Fans(nodes, np.count_nonzero(at, axis=1), middle, ring[at])

    def _pairs(
        self, depth: int, nodes: Mask, first: Indices, ranks: Indices, triangles: Indices
    ) -> None:
        """The two triangles of nodes without a finer neighbour."""
        step = 1 << (self._n - depth)
        grid = ranks[::step, ::step]
        p, q = grid[:-1, :-1][nodes], grid[:-1, 1:][nodes]
        r, s = grid[1:, 1:][nodes], grid[1:, :-1][nodes]
        anti, at = self._anti[depth][nodes], first[nodes]
        one: tuple[Any, ...] = (p, q, np.where(anti, s, r))
        two = (np.where(anti, q, p), r, s)
        for k in range(3):
            triangles[at, k] = one[k]
            triangles[at + 1, k] = two[k]


def _emit_fans(fans: _Fans, first: Indices, ranks: Indices, triangles: Indices) -> None:
    """A triangle from each node's middle to each pair of neighbours around it."""
    counts, flat = fans.counts, ranks.ravel()
    begin = np.cumsum(counts) - counts
    following = np.arange(1, len(fans.around) + 1)
    following[begin + counts - 1] = begin
    around = flat[fans.around]
    at = np.repeat(first[fans.nodes] - begin, counts) + np.arange(len(around))
    triangles[at, 0] = np.repeat(flat[fans.middle], counts)
    triangles[at, 1] = around
    triangles[at, 2] = around[following]
