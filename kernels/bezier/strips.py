"""The triangles between a coarse triangle's inserted vertices, in whole numbers: the readable form of `strips.cl`.

Rows with vertices are strips: between two of them a zip takes, of the two edges that may come next, the shorter one.
Where a row ends short of a side a gap is left between its end and that side; its ears are cut off one by one.

Source: Concheiro 2013, sections 3.1.2 and 3.1.3 (strips of vertices, extreme and reused vertices). What is done in
detail is a reconstruction.
"""

from __future__ import annotations

from lodbench.kernels.bezier.candidates import CELL, COLUMN, ROW

Node = tuple[int, int]
Triangles = list[tuple[int, int, int]]


def strips(mask: int) -> Triangles:
    """The triangles of a mask, as ranks of its vertices, turning as the coarse triangle does."""
    vertices = [
        (int(r), int(c)) for k, (r, c) in enumerate(zip(ROW, COLUMN, strict=True)) if mask >> k & 1
    ]
    rank = {vertex: k for k, vertex in enumerate(vertices)}
    rows = [[v for v in vertices if v[0] == r] for r in range(CELL + 1)]
    made: list[tuple[Node, Node, Node]] = []
    left, right = [(0, 0)], [(0, 0)]
    above = rows[0]
    for row in filter(None, rows[1:]):
        made += _zipped(above, row)
        made += [(a, c, b) for a, b, c in _ears(left, row[0], lambda v: v[1])]
        made += _ears(right, row[-1], lambda v: v[0] - v[1])
        above = row
    return [(rank[a], rank[b], rank[c]) for a, b, c in made]


def _zipped(upper: list[Node], lower: list[Node]) -> list[tuple[Node, Node, Node]]:
    """The triangles between two rows."""
    a, b, down = 0, 0, lower[0][0] - upper[0][0]
    made = []
    while a + 1 < len(upper) or b + 1 < len(lower):
        to_low = abs(2 * (lower[b + 1][1] - upper[a][1]) - down) if b + 1 < len(lower) else 99
        to_up = abs(2 * (upper[a + 1][1] - lower[b][1]) + down) if a + 1 < len(upper) else 100
        if to_low <= to_up:
            made.append((upper[a], lower[b], lower[b + 1]))
            b += 1
        else:
            made.append((upper[a], lower[b], upper[a + 1]))
            a += 1
    return made


def _ears(chain: list[Node], vertex: Node, away) -> list[tuple[Node, Node, Node]]:
    """One more vertex on the chain beside a side: the ears that it closes, and the chain without them."""
    made = []
    while len(chain) > 1:
        first, ear = chain[-2:]
        x = away(first)
        if (away(ear) - x) * (vertex[0] - first[0]) <= (away(vertex) - x) * (ear[0] - first[0]):
            break
        made.append((first, ear, vertex))
        chain.pop()
    if away(vertex) == 0:
        chain.clear()  # all of it was cut: a new one begins
    chain.append(vertex)
    return made
