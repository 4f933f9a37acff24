"""Dynamic and adaptive tessellation in float64: which vertices each coarse triangle inserts."""

from __future__ import annotations

from lodbench.kernels.bezier.candidates import (
    BASE,
    EDGE_NODES,
    INSIDE,
    LEFT,
    LEVEL,
    RIGHT,
    ROW,
    SECTOR,
    Flags,
    columns,
)
from lodbench.kernels.bezier.measures import edge_levels, on_edges


def inserted(on: Flags, inside: Flags, depth: int) -> Flags:
    """Flags of all nodes, (..., nodes): on edges, and inside those candidates that pass.

    A node inside is a candidate where its level is at most that of the edge to whose third it belongs; also where its
    row has a vertex on the left or the right and its column may have one on the base (a reconstruction: a row that
    ended where a third does would leave a hollow).

    Args:
        on: (..., 3, 7) do places on left, right and base pass the test by themselves?
        inside: (..., nodes) does a node inside?
        depth: the finest level.

    Source: Concheiro 2013, section 3.2 (three levels for a triangle, each over a third of it).
    """
    made = on_edges(on, depth)
    return made | (inside & INSIDE & candidates(made, depth))


def candidates(inserted: Flags, depth: int) -> Flags:
    """Flags of the nodes that are tested, (..., nodes), by what is inserted on edges."""
    levels = edge_levels(inserted)
    rows = inserted[..., EDGE_NODES[LEFT]] | inserted[..., EDGE_NODES[RIGHT]]
    inside = INSIDE & (LEVEL <= levels[..., SECTOR])
    inside |= rows[..., ROW] & columns(levels[..., BASE])
    return inside | (~INSIDE & (LEVEL > 0) & (LEVEL <= depth))
