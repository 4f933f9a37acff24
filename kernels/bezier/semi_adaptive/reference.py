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

HALVES = (0, 1, 2, 5)
"""Sets of vertices on the half of an edge, by the finest level, in which each has those between which it lies."""


def pattern_count(depth: int) -> int:
    """Combinations of three edges: 1, 8, 125 or 17,576."""
    return (1 + HALVES[depth] ** 2) ** 3


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
