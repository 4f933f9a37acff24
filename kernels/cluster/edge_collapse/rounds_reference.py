"""One round of independent collapses as one reads it, in float64."""

from __future__ import annotations

import math

from lodbench.kernels.cluster.edge_collapse.reference import Edge, Real, Surface, merge

Collapse = tuple[int, int, Real]
"""The vertex that goes, the one that it goes to, and where that then lies, in the surface's units."""


def one_round(surface: Surface, threshold: float, passes: int) -> list[list[Collapse]]:
    """The collapses of each pass; all quadrics and costs are those of the surface as it came, which stays as it is.

    An edge wins where none at either end or at their neighbours is less, and goes where it may. In the next pass edges
    compete that no such collapse is near, those that may not go left out.

    Args:
        surface: triangles with fresh quadrics.
        threshold: what edges may cost.
        passes: how often they are selected.
    """
    kept = surface.border if surface.params.preserve_border else set[int]()
    costs: dict[Edge, float] = {}
    for u, v in surface.edges():
        cost, _ = merge(surface.quadrics[u], surface.quadrics[v])
        if cost <= threshold and not {u, v} & kept:
            costs[min(u, v), max(u, v)] = cost
    touched, result = set[int](), list[list[Collapse]]()
    for _ in range(passes):
        costs = {edge: cost for edge, cost in costs.items() if not touched & {*edge}}
        best: dict[int, float] = {}
        for edge, cost in costs.items():
            for v in edge:
                best[v] = min(best.get(v, math.inf), cost)
        result.append([])
        for u, v in winners(surface, costs, best):
            _, merged = merge(surface.quadrics[u], surface.quadrics[v])
            merged = surface.levelled(u, v, merged)
            if not surface.keeps_surface(u, v) or surface.turns(u, v, merged.p):
                del costs[u, v]
                continue
            result[-1].append((u, v, merged.p))
            touched |= surface.neighbours(u) | surface.neighbours(v)
    return result


def winners(surface: Surface, costs: dict[Edge, float], best: dict[int, float]) -> list[Edge]:
    """Edges that are the least in the rings of both ends; no triangle has corners of two of them."""
    return [
        (u, v)
        for (u, v), cost in costs.items()
        if all(best.get(w, math.inf) >= cost for w in surface.neighbours(u) | surface.neighbours(v))
    ]
