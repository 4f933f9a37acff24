"""The test "mean" in float64 and integers: the grid that each cell of a map takes, by its area and how it bends.

A cell is cut into 2^i x 2^j smaller ones, all along the same diagonal. Of all such grids it takes that whose share of
the surface's mean error, together with a price for each triangle, is least: when all have done so the sum over all
cells is least for as many triangles, since each of them saves the same, wherever it is. An edge has the finer of its
two cells' levels, which both have read. A grid is written as two halves of the cell:

```
halves of a cell, node (r, c) is number 9 r + c          12, 13: rows along j, i = r or 4 + r
0 <= r <= 4, 0 <= c <= 8                                 14, 15: rows along i, which is 8 - c; j = r or 4 + r
```

A cell of one segment each way remains two coarse triangles.

Source: none in Concheiro 2013, whose tests ask the same of a candidate wherever it is, and whose cells are triangles:
a reconstruction of what its figure 4.6 compares, at the least mean error.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.bezier import measures
from lodbench.kernels.bezier.borders import Borders
from lodbench.kernels.bezier.candidates import (
    CELL,
    DEEPEST,
    EDGE_NODES,
    NODES,
    SAMPLES,
    Flags,
    Integers,
    Masks,
    bits,
    cell_samples,
    nodes_of,
    triangle_counts,
    ways_of,
)
from lodbench.kernels.bezier.lattice import lattice_parameters
from lodbench.kernels.bezier.reference import Doubles, points_at
from lodbench.kernels.bezier.strips import Node, Triangles

SIZES = DEEPEST + 1
LEVEL_U, LEVEL_V = np.divmod(np.arange(SIZES * SIZES), SIZES)
"""Of each grid the levels along u and v: it has 2^(1 + LEVEL_U + LEVEL_V) triangles."""
AREA_STEPS = 16  # along each side of a patch, for the area of all
FIRST_HALF, OTHER_CUT = 12, 59  # the first way that is a half; the bit of a mask cut along b d

HALF = CELL // 2
HALF_ROW, HALF_COLUMN = np.divmod(np.arange(NODES), CELL + 1)
HALF_INSIDE = (HALF_ROW % HALF > 0) & (HALF_COLUMN % CELL > 0)
HALF_LEVEL = DEEPEST - np.log2(
    [(r | c | CELL) & -(r | c | CELL) for r, c in zip(HALF_ROW, HALF_COLUMN, strict=True)]
).astype(np.int64)
"""Of each node of a half, the least level at which a grid has it."""
PIECES = np.stack(
    [
        *SAMPLES,
        *((CELL + 1) * (HALF_ROW + k) + HALF_COLUMN for k in (0, HALF)),
        *((CELL + 1) * (CELL - HALF_COLUMN) + HALF_ROW + k for k in (0, HALF)),
    ]
)
"""(16, nodes) the sample under each node of each way."""


SUMMED = 9 * 720**0.5
"""What the kernel's sums lack: the mean of nine places, and the root of 720."""


def piece_triangles(masks: Masks) -> Integers:
    """How many triangles each coarse triangle or half has."""
    flags = nodes_of(masks)
    of_half = 2 * flags.sum(-1) - 2 - (flags & ~HALF_INSIDE).sum(-1)
    return np.where(ways_of(masks) < FIRST_HALF, triangle_counts(flags), of_half)


def piece_levels(masks: Masks) -> Integers:
    """The finest level of each coarse triangle, or half, (n,) of (n,)."""
    flags = nodes_of(masks)
    of_half = (flags * HALF_LEVEL).max(axis=-1, initial=1)
    return np.where(ways_of(masks) < FIRST_HALF, measures.edge_levels(flags).max(-1), of_half)


def surface_area(P: Doubles, inverse: float) -> float:
    """The area of patches, (m, 4, 4, 3), in squares of the diagonal that `inverse` is one over."""
    t = np.arange(AREA_STEPS + 1) / AREA_STEPS
    u, v = (a.ravel() for a in np.meshgrid(t, t, indexing="ij"))
    points = (points_at(P, u, v) * inverse).reshape(-1, AREA_STEPS + 1, AREA_STEPS + 1, 3)
    across = points[:, 1:, 1:] - points[:, :-1, :-1]
    back = points[:, 1:, :-1] - points[:, :-1, 1:]
    return float(np.linalg.norm(np.cross(across, back), axis=-1).sum() / 2)


def grid_errors(P: Doubles, base: int, inverse: float) -> tuple[Doubles, Doubles]:
    """How far each grid of each cell is off the surface, times the cell's area, (m, cells, 2 diagonals, grids); areas.

    The surface is taken as quadratic about nine places of the cell. There the differences d1 d2 d3 of a triangle's
    three edges from their chords give a root mean square of sqrt(((d1 + d2 + d3)^2 + d1^2 + d2^2 + d3^2) / 720).
    """
    level = base + DEEPEST
    u, v = lattice_parameters(level)
    where = cell_samples(level).reshape(-1, CELL + 1, CELL + 1)[:, ::2, ::2]
    p = points_at(P, u, v)[:, where] * inverse

    def at(i: int, j: int) -> Doubles:
        return p[:, :, 1 + i : 4 + i, 1 + j : 4 + j]

    normal = np.cross(at(1, 0) - at(-1, 0), at(0, 1) - at(0, -1)) * 4
    area = np.linalg.norm(normal, axis=-1)
    normal /= np.where(area > 0, area, 1)[..., None]
    a, b, c = (
        (second * normal).sum(-1)[..., None]
        for second in (
            (at(1, 0) + at(-1, 0) - 2 * at(0, 0)) * 16,
            (at(1, 1) + at(-1, -1) - at(1, -1) - at(-1, 1)) * 4,
            (at(0, 1) + at(0, -1) - 2 * at(0, 0)) * 16,
        )
    )
    a, b, c = a * 0.25**LEVEL_U, b * 0.5 ** (LEVEL_U + LEVEL_V), c * 0.25**LEVEL_V
    found = []
    for third in (a + c + 2 * b, a + c - 2 * b):
        square = (a + c + third) ** 2 + a * a + c * c + third * third
        found.append((np.sqrt(square / 720) * area[..., None]).sum((2, 3)) / 9)
    return np.stack(found, axis=2), area.mean((2, 3))


def rings(found: Borders, base: int) -> NDArray[np.uint32]:
    """For each edge of each cell, 4 cell + edge, the next of those that are one, in a ring: (4 cells of all patches,).

    Edges of a cell are numbered like a patch's.
    """
    count, n = len(found.curve), 1 << base
    patch, i, j = np.meshgrid(np.arange(count), np.arange(n), np.arange(n), indexing="ij")
    keys = []
    for edge in range(4):
        line, place = (i, j) if edge < 2 else (j, i)
        line = line + (edge & 1)
        key = ((2 * patch + edge // 2) * (n + 1) + line) * n + place
        on = (line == (n if edge & 1 else 0)) & ~found.collapsed[:, edge, None, None]
        along = np.where(found.turned[:, edge, None, None], n - 1 - place, place)
        shared = 2 * count * (n + 1) * n + found.curve[:, edge, None, None] * n + along
        keys.append(np.where(on, shared, key))
    key = np.stack(keys, axis=-1).ravel()
    order = np.argsort(key, kind="stable")
    is_last = np.append(key[order][1:] != key[order][:-1], True)
    first = np.append(0, np.flatnonzero(is_last)[:-1] + 1)
    after = np.arange(1, len(key) + 1)
    after[is_last] = first
    ring = np.empty(len(key), np.uint32)
    ring[order] = order[after]
    return ring


def edge_levels(wishes: Integers, ring: NDArray[np.uint32]) -> Integers:
    """The level of each edge of each cell, (cells, 4), by the wishes of all cells on it."""
    own = np.stack([wishes >> 2 & 3] * 2 + [wishes & 3] * 2, axis=-1).ravel()
    level, at = own.copy(), ring
    while (at != np.arange(len(ring))).any():
        level, at = np.maximum(level, own[at]), ring[at]
    return level.reshape(-1, 4)


def _on(level: Integers) -> Flags:
    """Which of nine places along an edge of a level, (...), have a vertex: (..., 9)."""
    return np.arange(CELL + 1) % (CELL >> level[..., None]) == 0


def grid_masks(wishes: Integers, edges: Integers) -> Masks:
    """Both masks of each cell, (cells, 2), by its wish and the levels of its edges."""
    u, v, other = wishes & 3, wishes >> 2 & 3, wishes >> 4
    found = np.zeros((len(wishes), 2), np.uint64)
    for k in (0, 1):
        along = _half(np.where(k, edges[:, 1], edges[:, 0]), v, u, edges[:, 2], edges[:, 3], k)
        across = _half(np.where(k, edges[:, 3], edges[:, 2]), u, v, edges[:, 1], edges[:, 0], k)
        way = np.where(u > 0, FIRST_HALF + k, FIRST_HALF + 2 + k)
        mask = np.where(u > 0, along, across) | (other ^ (u == 0)).astype(np.uint64) << OTHER_CUT
        whole = np.zeros((len(wishes), NODES), bool)
        none = np.zeros_like(u)
        cut = ((edges[:, 2], none, edges[:, 1]), (edges[:, 2], edges[:, 0], none)) if k == 0 else (
            (none, edges[:, 0], edges[:, 3]), (edges[:, 1], none, edges[:, 3]))  # fmt: skip
        for edge, levels in enumerate(zip(*cut, strict=True)):
            whole[:, EDGE_NODES[edge]] |= _on(np.where(other, levels[1], levels[0]))
        is_whole = (u == 0) & (v == 0)
        mask = np.where(is_whole, bits(whole), mask)
        way = np.where(is_whole, 3 * k + 6 * other, way)
        found[:, k] = mask | way.astype(np.uint64) << np.uint64(60)
    return found


def _half(
    outer: Integers, columns: Integers, rows: Integers, left: Integers, right: Integers, k: int
) -> Masks:
    """The nodes of half k of cells: by the level of its outer row, of its columns and rows, and of both sides."""
    on = np.zeros((len(outer), HALF + 1, CELL + 1), bool)
    on[:, HALF * k ^ HALF], on[:, HALF * k] = _on(columns), _on(outer)
    on[:, 1:HALF, 1:-1] = (_on(rows)[:, 1:HALF, None] & _on(columns)[:, None])[..., 1:-1]
    on[:, 1:HALF, 0], on[:, 1:HALF, -1] = _on(left)[:, 1:HALF], _on(right)[:, 1:HALF]
    return bits(on.reshape(len(outer), -1))


def half_strips(mask: int) -> Triangles:
    """The triangles of a half, as ranks of its vertices.

    Rows that have all columns are strips, zipped as in `strips`; the first and last triangle between two of them fan
    out to the vertices that a side has beside them.
    """
    side = CELL + 1
    rows = [mask >> side * r & (1 << side) - 1 for r in range(HALF + 1)]
    whole = [r for r in range(HALF + 1) if not rows[0] & rows[HALF] & ~rows[r]]
    found: list[tuple[Node, Node, Node]] = []
    for above, below in pairwise(whole):
        upper, lower = ([c for c in range(side) if rows[r] >> c & 1] for r in (above, below))
        a = b = 0
        while a + 1 < len(upper) or b + 1 < len(lower):
            to_low = abs(lower[b + 1] - upper[a]) if b + 1 < len(lower) else 99
            to_up = abs(upper[a + 1] - lower[b]) if a + 1 < len(upper) else 99
            down = to_low + (mask >> OTHER_CUT & 1) <= to_up
            top, low = (above, upper[a]), (below, lower[b])
            tip = (below, lower[b + 1]) if down else (above, upper[a + 1])
            is_first = a == b == 0
            a, b = (a, b + 1) if down else (a + 1, b)
            is_last = a + 1 == len(upper) and b + 1 == len(lower)
            if is_first:
                found += [(x, y, tip) for x, y in _side(rows, above, below, 0)]
            elif is_last:
                found += [(low if down else top, y, x) for x, y in _side(rows, above, below, CELL)]
            else:
                found.append((top, low, tip))
    rank = [(mask & (1 << k) - 1).bit_count() for k in range(NODES)]
    return [tuple(rank[side * r + c] for r, c in triangle) for triangle in found]


def _side(rows: list[int], above: int, below: int, c: int) -> list[tuple[Node, Node]]:
    """What lies between vertices on a side, from row to row."""
    between = [r for r in range(above + 1, below) if rows[r] >> c & 1]
    return [((a, c), (b, c)) for a, b in pairwise([above, *between, below])]
