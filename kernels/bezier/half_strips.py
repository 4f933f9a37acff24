"""The triangles of half a cell that is cut into a grid, in whole numbers: the readable form of `half_strips.cl`."""

from __future__ import annotations

from itertools import pairwise

from lodbench.kernels.bezier.candidates import CELL, NODES
from lodbench.kernels.bezier.strips import Node, Triangles

HALF = CELL // 2  # rows of a half; node (r, c) is number 9 r + c
COLUMNS_BIT, OTHER_CUT = 57, 59
"""Of a mask: log2 of its columns, two bits; is it cut from lower left to upper right?"""


def half_strips(mask: int) -> Triangles:
    """The triangles of a half, as ranks of its vertices.

    Rows that have all columns are strips, zipped as in `strips`; the first and last triangle between two of them fan
    out to the vertices that a side has beside them.
    """
    side = CELL + 1
    rows = [mask >> side * r & (1 << side) - 1 for r in range(HALF + 1)]
    step = CELL >> (mask >> COLUMNS_BIT & 3)
    columns = sum(1 << c for c in range(0, side, step))
    whole = [r for r in range(HALF + 1) if not columns & ~rows[r]]
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
    ranks = {(r, c): rank[side * r + c] for r in range(HALF + 1) for c in range(side)}
    return [(ranks[a], ranks[b], ranks[c]) for a, b, c in found]


def _side(rows: list[int], above: int, below: int, c: int) -> list[tuple[Node, Node]]:
    """What lies between vertices on a side, from row to row."""
    between = [r for r in range(above + 1, below) if rows[r] >> c & 1]
    return [((a, c), (b, c)) for a, b in pairwise([above, *between, below])]
