"""Semi-adaptive tessellation in float64: which vertices each coarse triangle has, by its edges alone."""

from __future__ import annotations

from lodbench.kernels.bezier.candidates import (
    BASE,
    EDGE_NODES,
    LEFT,
    RIGHT,
    ROW,
    Flags,
    columns,
)
from lodbench.kernels.bezier.measures import edge_levels, on_edges

PATTERNS = 26**3
"""Of the sets of vertices on an edge in which each has those between which it lies there are 1 + 5^2, and of a half's
1 + 2^2."""


def inserted(on: Flags, inside: Flags, depth: int) -> Flags:
    """Flags of all nodes, (..., nodes): on edges as `dabt` has them, inside whole rows.

    A row is empty where neither side has a vertex. Else it has vertices as close as the base asks, whatever is inside.

    Args:
        on: (..., 3, 7) do places on left, right and base pass the test by themselves?
        inside: not asked.
        depth: the finest level.

    Source: Concheiro 2013, section 4.2 (one level for all rows; no empty rows, empty rows, missing vertices). What
    makes a row empty, and that the base has the level, is a reconstruction.
    """
    made = on_edges(on, depth)
    rows = made[..., EDGE_NODES[LEFT]] | made[..., EDGE_NODES[RIGHT]]
    return made | (rows[..., ROW] & columns(edge_levels(made)[..., BASE]))
