"""Where a coarse triangle may have vertices, by whole numbers: the nodes of its pattern, their levels, their sectors.

```
row 0         0                node (r, c), 0 <= c <= r <= 8, is number r (r + 1) / 2 + c, its bit in a mask
row 1       1   2              left edge c = 0, right edge c = r, base r = 8
row 2     3   4   5            barycentric (8 - r, r - c, c)
...

a cell has samples 9 i + j        a - d    j across         ways of the two triangles of a cell, as the corners at
and corners a b c d               |   |    i down           row 0, left and right end of the base:
                                  b - c                     0 abc  1 bca  2 cab    3 acd  4 cda  5 dac
                                                            6 abd  7 bda  8 dab    9 bcd 10 cdb 11 dbc
```

Source: Concheiro 2013, chapter 3: the pattern, levels 0 to 3, one level per edge, each for the third of the triangle
that is next to it. That the third is that of the smallest barycentric coordinate, and the ways, are reconstructions.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.bezier.lattice import side_vertices

Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]
Masks = NDArray[np.uint64]

DEEPEST = 3
"""The finest of a triangle's levels: 64 triangles of 12 numbers each are 768 of the 1024 that a geometry shader may
emit; four times as many are not."""
CELL = 1 << DEEPEST
ROW, COLUMN = np.tril_indices(CELL + 1)
NODES = len(ROW)
LEFT, RIGHT, BASE = 0, 1, 2
_BARYCENTRIC = np.stack([CELL - ROW, ROW - COLUMN, COLUMN])
_TOGETHER = np.bitwise_or.reduce(_BARYCENTRIC)
LEVEL = DEEPEST - np.log2(_TOGETHER & -_TOGETHER).astype(np.int64)
"""Of each node: 0 at corners, 1 in the middle of edges, up to 3."""
SECTOR = np.array([BASE, RIGHT, LEFT])[_BARYCENTRIC.argmin(axis=0)]
"""Of each node, the edge to whose third it belongs."""
INSIDE = (_BARYCENTRIC > 0).all(axis=0)
EDGE_NODES = np.array([[r * (r + 1) // 2 for r in range(CELL + 1)],
                       [r * (r + 3) // 2 for r in range(CELL + 1)],
                       [CELL * (CELL + 1) // 2 + c for c in range(CELL + 1)]])  # fmt: skip
"""(3, 9) the nodes on the left and the right from row 0 on, and on the base."""

_A, _B, _C, _D = 0, 72, 80, 8
_TRIANGLES = ((_A, _B, _C), (_A, _C, _D), (_A, _B, _D), (_B, _C, _D))
CORNERS = np.array([np.roll(corners, -turn) for corners in _TRIANGLES for turn in range(3)])
"""(12, 3) samples at the corners of each way."""
SAMPLES = CORNERS @ _BARYCENTRIC // CELL
"""(12, nodes) the sample under each node of each way."""
_LANES = np.arange(NODES, dtype=np.uint64)


def bits(nodes: Flags) -> Masks:
    """Flags of nodes, (..., nodes), as masks."""
    return (nodes.astype(np.uint64) << _LANES).sum(-1, dtype=np.uint64)


def nodes_of(masks: Masks) -> Flags:
    """Masks, (...), as flags of nodes, (..., nodes)."""
    return (masks[..., None] >> _LANES & np.uint64(1)).astype(bool)


def ways_of(masks: Masks) -> Integers:
    """The way of each mask."""
    return (masks >> np.uint64(60)).astype(np.int64)


def columns(level: Integers | int) -> Flags:
    """Nodes inside whose column a base of this level, (...), has a vertex in, (..., nodes)."""
    return INSIDE & (COLUMN % (CELL >> np.asarray(level))[..., None] == 0)


def candidate_masks() -> Masks:
    """Masks that kernels read, (17,): of candidates inside by edge and by that edge's level, 0 to 3; of `columns` of
    levels 0 to 3; of all nodes on edges.
    """
    found = [
        INSIDE & (SECTOR == edge) & (LEVEL <= level)
        for edge in (LEFT, RIGHT, BASE)
        for level in range(DEEPEST + 1)
    ]
    return bits(np.stack([*found, *columns(np.arange(DEEPEST + 1)), ~INSIDE]))


def triangle_counts(flags: Flags) -> Integers:
    """How many triangles lie between the vertices of each coarse triangle: 2 V - 2 - those on edges."""
    return 2 * flags.sum(-1) - 2 - (flags & ~INSIDE).sum(-1)


def cell_samples(level: int) -> Integers:
    """The virtual vertices of a patch's map under the samples of its cells, (cells, 81), row after row."""
    side = side_vertices(level)
    across = (side - 1) // CELL
    i, j = np.divmod(np.arange(across * across), across)
    own = np.add.outer(np.arange(CELL + 1) * side, np.arange(CELL + 1)).ravel()
    return (CELL * (i * side + j))[:, None] + own
