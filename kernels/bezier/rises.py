"""How far vertices rise over the surface, in float64 and integers: the readable form of `rises.cl`.

An inscribed triangle lies on one side of what bends one way. Where each half of a cell rises by what its triangles lie
under the surface in the mean, triangles lie on both sides and the mean error is a third to a half. A vertex rises along
its normal, by the mean of the quarters of cells around it; those on creases, poles and other borders without a common
normal stay.

Source: none in Concheiro 2013, whose vertices lie on the surface: a reconstruction.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.bezier.borders import ENDS, Borders, sharing
from lodbench.kernels.bezier.candidates import CELL, Integers
from lodbench.kernels.bezier.grids import Bends, Wish, ring_of
from lodbench.kernels.bezier.reference import Doubles

UNITS = 1 << 28  # of a diagonal
MOST = 1 << 26
MIDDLE = np.array([[1, 0], [1, 0], [1, 0], [1, 0], [0.5, 0.5], [0, 1], [0, 1], [0, 1], [0, 1]])
"""Shares of both halves at nine places of a cell."""


def corner_ring(found: Borders, base: int) -> NDArray[np.uint32]:
    """For each corner of each cell, 4 cell + 2 [end of u] + [end of v], the next of those that are one, in a ring."""
    return ring_of(_corners(sharing(found, base)[0], base).ravel())


def _corners(of_lattice: NDArray, base: int) -> NDArray:
    """What the corners of cells have, (m, cells, 4), of what the lattice of a level has, (m, (n + 1)^2)."""
    n = 1 << base
    grid = of_lattice.reshape(-1, n + 1, n + 1)
    each = [grid[:, i : n + i, j : n + j] for i in (0, 1) for j in (0, 1)]
    return np.stack(each, axis=-1).reshape(len(grid), n * n, 4)


def held(found: Borders, base: int) -> NDArray[np.uint32]:
    """Which edges, bits 0 to 3, and corners, from bit 4 on, of each cell stay on the surface, (cells of all patches,).

    Where a border has several normals, none, or is a point.
    """
    count, n = len(found.curve), 1 << base
    own = np.arange(4 * count).reshape(count, 4)
    bent = found.collapsed | ((found.owner != own) & ~found.smooth)
    edges = bent.ravel() & False
    np.logical_or.at(edges, found.owner.ravel(), bent.ravel())
    edges = edges[found.owner]
    points = np.zeros(found.corner.max(initial=-1) + 1, bool)
    first = np.full(len(points), -1)
    first[found.corner.ravel()[::-1]] = found.corner_owner.ravel()[::-1]
    np.logical_or.at(points, found.corner, found.corner_owner != first[found.corner])
    for edge, ends in enumerate(ENDS):
        points[found.corner[found.collapsed[:, edge]][:, ends]] = True
    lattice = np.zeros((count, n + 1, n + 1), bool)
    sides = (lattice[:, 0], lattice[:, n], lattice[:, :, 0], lattice[:, :, n])
    bits = np.zeros((count, n, n), np.uint32)
    cells = (bits[:, 0], bits[:, n - 1], bits[:, :, 0], bits[:, :, n - 1])
    for edge, (side, along) in enumerate(zip(sides, cells, strict=True)):
        side |= edges[:, edge, None]
        along |= edges[:, edge, None].astype(np.uint32) << np.uint32(edge)
    for corner in range(4):
        lattice[:, corner // 2 * n, corner % 2 * n] = points[found.corner[:, corner]]
    corners = _corners(lattice, base).astype(np.uint32) << np.arange(4, 8, dtype=np.uint32)
    return (bits.reshape(count, n * n) | corners.sum(-1, dtype=np.uint32)).ravel()


def half_rises(bends: Bends, wish: Wish) -> Doubles:
    """How far each half of cells, (cells, 2), lies under the surface in the mean, in diagonals: see `grids`."""
    shares = np.array([[1, 0.5, 0], [0, 0.5, 1]])
    a, b, c, area = (part.reshape(-1, 3, 3) for part in (bends.u, bends.both, bends.v, bends.area))
    down = (wish.cut != 2)[:, None]
    whole = (wish.cut == 0)[:, None]
    rows = np.where(whole, 0, wish.rows + 1)
    columns = np.where(whole, 0, wish.columns)
    other = np.where(whole, wish.other[:, :1], wish.other)
    level_u, level_v = np.where(down, rows, columns), np.where(down, columns, rows)

    def of_halves(numbers: Doubles) -> Doubles:
        """Each half's sum of the nine places."""
        along, across = (numbers.sum(axis) @ shares.T for axis in (2, 1))
        return np.where(down, along, across)

    sums = of_halves(a * area), of_halves(b * area), of_halves(c * area)
    under = sums[0] * 0.25**level_u + sums[2] * 0.25**level_v
    under = under + np.where(other, -1, 1) * sums[1] * 0.5 ** (level_u + level_v)
    size = of_halves(area)
    return np.where(size > 0, under / np.where(size > 0, -12 * size, 1), 0)


def place_rises(
    wishes: Integers, rises: Integers, rings: tuple[Integers, Integers], held: Integers
) -> Doubles:
    """How far the nine by nine places of each cell rise, (cells, 9, 9), in diagonals.

    Args:
        wishes: (cells,).
        rises: of each half, (cells, 2), in `UNITS` of a diagonal.
        rings: of edges and of corners, (4 cells,) each: see `grids.rings`, `corner_ring`.
        held: (cells,).
    """
    across = (Wish.of(wishes).cut == 2)[:, None, None]
    quarters = np.where(across, rises[:, None, :], rises[:, :, None]) + np.zeros((2, 2), np.int64)
    found = MIDDLE @ quarters @ MIDDLE.T
    sides = np.stack([quarters[:, 0], quarters[:, 1], quarters[:, :, 0], quarters[:, :, 1]], axis=1)
    ring, corner_ring = rings
    turned = (ring & 1).astype(bool)[:, None]
    edges = np.where(turned, sides.reshape(-1, 2)[:, ::-1], sides.reshape(-1, 2))
    edges = _mean_of_ring(edges, ring >> 1)
    edges = np.where(turned, edges[:, ::-1], edges).reshape(-1, 4, 2) @ MIDDLE.T
    corners = _mean_of_ring(quarters.reshape(-1, 1), corner_ring).reshape(-1, 4)
    stays = (held[:, None] >> np.arange(8) & 1).astype(bool)
    edges[stays[:, :4]], corners[stays[:, 4:]] = 0, 0
    found[:, 0], found[:, CELL], found[:, :, 0], found[:, :, CELL] = edges.swapaxes(0, 1)
    found[:, [0, 0, CELL, CELL], [0, CELL, 0, CELL]] = corners
    return found / UNITS


def _mean_of_ring(own: Integers, ring: Integers) -> Doubles:
    """The mean of all that are one, (n, k)."""
    found, count, at = own.copy(), np.ones(len(own)), ring
    while (others := at != np.arange(len(ring))).any():
        found, count = found + np.where(others[:, None], own[at], 0), count + others
        at = np.where(others, ring[at], at)
    return found / count[:, None]
