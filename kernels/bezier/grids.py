"""The test "mean" in float64 and integers: the grids that each cell of a map takes, by its area and how it bends.

A cell remains two coarse triangles, or is cut into halves: across u or v, each half with 1, 2 or 4 rows of up to eight
columns and along one diagonal. Of all such it takes that whose share of the surface's mean error, together with a price
for each triangle, is least: when all have done so the sum over all cells is least for as many triangles, since each of
them saves the same, wherever it is. An edge has the vertices that either of its cells wishes for.

```
halves of a cell, node (r, c) is number 9 r + c          ways 12, 13: rows along j, i = r or 4 + r
0 <= r <= 4, 0 <= c <= 8                                 ways 14, 15: rows along i, which is 8 - c; j = r or 4 + r

a wish: in bits 0, 1 how it is cut (0 not, 1 ways 12 and 13, 2 ways 14 and 15), then five bits for each half: log2 of
its rows and columns, two each, and whether along b d; of a cell that is not cut the first half's last bit counts
```

Source: none in Concheiro 2013, whose tests ask the same of a candidate wherever it is, and whose cells are triangles:
a reconstruction of what its figure 4.6 compares, at the least mean error.
"""

from __future__ import annotations

from dataclasses import dataclass

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
from lodbench.kernels.bezier.half_strips import COLUMNS_BIT, HALF, OTHER_CUT
from lodbench.kernels.bezier.lattice import lattice_parameters
from lodbench.kernels.bezier.reference import Doubles, points_at

SIZES = DEEPEST + 1
LEVEL_U, LEVEL_V = np.divmod(np.arange(SIZES * SIZES), SIZES)
"""Of each grid the levels along u and v: it has 2^(1 + LEVEL_U + LEVEL_V) triangles."""
AREA_STEPS = 16  # along each side of a patch, for the area of all
FIRST_HALF = 12  # the first way that is a half

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
MEAN_SHARE = (1.0, -0.25)  # of the mean's square in an error, vertices on the surface or fitted


def piece_triangles(masks: Masks) -> Integers:
    """How many triangles each coarse triangle or half has."""
    flags = nodes_of(masks)
    of_half = 2 * flags.sum(-1) - 2 - (flags & ~HALF_INSIDE).sum(-1)
    return np.where(ways_of(masks) < FIRST_HALF, triangle_counts(flags), of_half)


def piece_levels(masks: Masks) -> Integers:
    """The finest level of each coarse triangle, or half, (n,) of (n,)."""
    flags = nodes_of(masks)
    of_half = (flags * HALF_LEVEL).max(axis=-1, initial=1)  # whatever is cut has a level
    return np.where(ways_of(masks) < FIRST_HALF, measures.edge_levels(flags).max(-1), of_half)


def surface_area(P: Doubles, inverse: float) -> float:
    """The area of patches, (m, 4, 4, 3), in squares of the diagonal that `inverse` is one over."""
    t = np.arange(AREA_STEPS + 1) / AREA_STEPS
    u, v = (a.ravel() for a in np.meshgrid(t, t, indexing="ij"))
    points = (points_at(P, u, v) * inverse).reshape(-1, AREA_STEPS + 1, AREA_STEPS + 1, 3)
    across = points[:, 1:, 1:] - points[:, :-1, :-1]
    back = points[:, 1:, :-1] - points[:, :-1, 1:]
    return float(np.linalg.norm(np.cross(across, back), axis=-1).sum() / 2)


@dataclass(frozen=True, eq=False)
class Wish:
    """What wishes say, (cells,) of `cut` and (cells, 2) of each half.

    Attributes:
        cut: 0 not, 1 into halves with rows along v, 2 along u.
        rows, columns: log2 of how many.
        other: along b d.
    """

    cut: Integers
    rows: Integers
    columns: Integers
    other: Integers

    @staticmethod
    def of(wishes: Integers) -> Wish:
        """Of the words that the kernel writes."""
        half = wishes[:, None] >> np.array([2, 7])
        return Wish(wishes & 3, half & 3, half >> 2 & 3, half >> 4 & 1)


@dataclass(frozen=True, eq=False)
class Bends:
    """How cells bend about nine places, (m, cells, 3, 3) each, in diagonals.

    Attributes:
        u, both, v: second differences over the whole cell, along its normal.
        area: of the cell, as it is there.
    """

    u: Doubles
    both: Doubles
    v: Doubles
    area: Doubles


def cell_bends(P: Doubles, base: int, inverse: float) -> Bends:
    """Of patches, (m, 4, 4, 3), with cells of a level; `inverse` is one over the diagonal."""
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
        (second * normal).sum(-1)
        for second in (
            (at(1, 0) + at(-1, 0) - 2 * at(0, 0)) * 16,
            (at(1, 1) + at(-1, -1) - at(1, -1) - at(-1, 1)) * 4,
            (at(0, 1) + at(0, -1) - 2 * at(0, 0)) * 16,
        )
    )
    return Bends(a, b, c, area)


def grid_costs(bends: Bends, price: float, fitted: bool) -> tuple[Doubles, Doubles, Doubles]:
    """What cells and their halves cost with each grid: what it is off the surface, times area, and a price a triangle.

    The surface is taken as quadratic about nine places of the cell, of which the middle ones count for either half.
    There the differences d1 d2 d3 of a triangle's three edges from their chords give a root mean square of
    sqrt(((d1 + d2 + d3)^2 + d1^2 + d2^2 + d3^2) / 720), and a mean of (d1 + d2 + d3) / 24, without which there remains,
    if `fitted`, sqrt((d1^2 + d2^2 + d3^2 - (d1 + d2 + d3)^2 / 4) / 720).

    Returns:
        Of cells that are not cut, (m, cells, 2 diagonals); of halves, (m, cells, 2 cuts, 2 halves, 2 diagonals, 3 rows,
        4 columns); the areas of cells, (m, cells).
    """
    a, b, c = (part[..., None] for part in (bends.u, bends.both, bends.v))
    area, mean = bends.area, MEAN_SHARE[fitted]
    a, b, c = a * 0.25**LEVEL_U, b * 0.5 ** (LEVEL_U + LEVEL_V), c * 0.25**LEVEL_V
    found = []
    for third in (a + c + 2 * b, a + c - 2 * b):
        square = mean * (a + c + third) ** 2 + a * a + c * c + third * third
        found.append(np.sqrt(np.maximum(square, 0) / 720) * area[..., None] / 9)
    off = np.stack(found, axis=-2)  # (m, cells, 3, 3, 2, grids)
    shares = np.array([[1, 0.5, 0], [0, 0.5, 1]])
    along = np.einsum("hi,mcijdg->mchdg", shares, off)
    across = np.einsum("hj,mcijdg->mchdg", shares, off)
    shape = (*along.shape[:-1], SIZES, SIZES)
    halves = np.stack([along.reshape(shape), across.reshape(shape).swapaxes(-1, -2)], axis=2)
    triangles = 2 << np.add.outer(np.arange(SIZES - 1), np.arange(SIZES))
    whole = off[..., 0].sum((2, 3)) + 2 * price
    costs = (halves[..., 1:, :] + price * triangles).astype(np.float64)
    return whole, costs, area.mean((2, 3))


def rings(found: Borders, base: int) -> NDArray[np.uint32]:
    """For each edge of each cell, 4 cell + edge, the next of those that are one, in a ring: (4 cells of all patches,).

    Edges of a cell are numbered like a patch's. Of each number the lowest bit says that its own edge runs against the
    curve that it is on.
    """
    count, n = len(found.curve), 1 << base
    patch, i, j = np.meshgrid(np.arange(count), np.arange(n), np.arange(n), indexing="ij")
    keys, turns = [], []
    for edge in range(4):
        line, place = (i, j) if edge < 2 else (j, i)
        line = line + (edge & 1)
        key = ((2 * patch + edge // 2) * (n + 1) + line) * n + place
        on = (line == (n if edge & 1 else 0)) & ~found.collapsed[:, edge, None, None]
        turned = on & found.turned[:, edge, None, None]
        shared = found.curve[:, edge, None, None] * n + np.where(turned, n - 1 - place, place)
        keys.append(np.where(on, 2 * count * (n + 1) * n + shared, key))
        turns.append(turned)
    ring = ring_of(np.stack(keys, axis=-1).ravel())
    return 2 * ring + np.stack(turns, axis=-1).ravel()


def ring_of(key: Integers) -> NDArray[np.uint32]:
    """For each key, (n,), where the next of its value is, in a ring."""
    order = np.argsort(key, kind="stable")
    is_last = np.append(key[order][1:] != key[order][:-1], True)[: len(key)]
    first = np.append(0, np.flatnonzero(is_last)[:-1] + 1)
    after = np.arange(1, len(key) + 1)
    after[is_last] = first[: is_last.sum()]
    ring = np.empty(len(key), np.uint32)
    ring[order] = order[after]
    return ring


def _on(level: Integers) -> Flags:
    """Which of nine places along an edge of a level, (...), have a vertex: (..., 9)."""
    return np.arange(CELL + 1) % (CELL >> level[..., None]) == 0


def _sides(wish: Wish) -> Flags:
    """Places on the edges that run from half to half, (cells, 9), where a half has rows."""
    return np.concatenate([_on(wish.rows[:, 0])[:, ::2], _on(wish.rows[:, 1])[:, 2::2]], axis=1)


def edges_of(wishes: Integers, ring: NDArray[np.uint32]) -> Flags:
    """Which of nine places of each edge of each cell have a vertex, (cells, 4, 9), by the wishes of all cells on it."""
    wish = Wish.of(wishes)
    sides, ends = _sides(wish), _on(wish.columns)
    pairs = np.where((wish.cut == 1)[:, None, None, None], np.stack([ends, np.stack([sides, sides], 1)], 1),
                     np.stack([np.stack([sides, sides], 1), ends], 1))  # fmt: skip
    own = np.where((wish.cut > 0)[:, None, None], pairs.reshape(-1, 4, CELL + 1), _on(np.array(0)))
    own = own.reshape(-1, CELL + 1)
    turned = (ring & 1).astype(bool)[:, None]
    own = np.where(turned, own[:, ::-1], own)
    found, at = own.copy(), ring >> 1
    while (at != np.arange(len(ring))).any():
        found, at = found | own[at], ring[at] >> 1
    return np.where(turned, found[:, ::-1], found).reshape(-1, 4, CELL + 1)


def grid_masks(wishes: Integers, edges: Flags) -> Masks:
    """Both masks of each cell, (cells, 2), by its wish and what is on its edges, (cells, 4, 9)."""
    wish = Wish.of(wishes)
    found = np.zeros((len(wishes), 2), np.uint64)
    none = np.broadcast_to(_on(np.array(0)), edges[:, 0].shape)
    e = edges.swapaxes(0, 1)
    for k in (0, 1):
        along = _half(wish, k, e[k], e[2], e[3])
        across = _half(wish, k, e[2 + k][:, ::-1], e[1], e[0])
        last = e[3][:, ::-1]  # from c to d
        cuts = (
            ((e[2], none, e[1]), (e[2], e[0], none))
            if k == 0
            else ((none, e[0], last), (e[1], none, last))
        )
        whole = np.zeros((2, len(wishes), NODES), bool)
        for one, cut in zip(whole, cuts, strict=True):
            for edge, places in enumerate(cut):
                one[:, EDGE_NODES[edge]] |= places
        other = wish.other[:, 0]
        uncut = np.where(other, bits(whole[1]), bits(whole[0])), 3 * k + 6 * other
        ways = np.where(wish.cut == 0, uncut[1], FIRST_HALF - 2 + 2 * wish.cut + k)
        masks = np.choose(wish.cut, [uncut[0], along, across])
        found[:, k] = masks | ways.astype(np.uint64) << np.uint64(60)
    return found


def _half(wish: Wish, k: int, outer: Flags, left: Flags, right: Flags) -> Masks:
    """Half k of cells by what is on its outer edge and its sides: nodes, columns, and which diagonal."""
    on = np.zeros((len(outer), HALF + 1, CELL + 1), bool)
    on[:, HALF * k], on[:, HALF * k ^ HALF] = outer, _on(wish.columns.max(axis=1))
    rows, columns = _on(wish.rows[:, k])[:, ::2], _on(wish.columns[:, k])
    on[:, 1:HALF, 1:-1] = (rows[:, 1:HALF, None] & columns[:, None])[..., 1:-1]
    for c, side in ((0, left), (-1, right)):
        on[:, 1:HALF, c] = side[:, HALF * k + 1 : HALF * k + HALF]
    other = wish.other[:, k] ^ (wish.cut == 2)  # rows of the second cut are turned by a quarter
    facts = wish.columns[:, k] << COLUMNS_BIT | other << OTHER_CUT
    return bits(on.reshape(len(outer), NODES)) | facts.astype(np.uint64)
