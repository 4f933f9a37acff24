"""What an octree's nodes are joined to, in float64 and written for reading: cubes, and boxes of their children."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.cluster.octree.reference import (
    RIDGES,
    Floats,
    Integers,
    Tree,
    energies,
    moved,
)
from lodbench.kernels.cluster.quadric_clustering.reference import place

ALONE = -1  # joined to none


def solved(
    tree: Tree, parents: Integers, members: Integers, rows: Integers
) -> tuple[Floats, Floats, Floats, Floats]:
    """Representatives (k, 3), energies, areas and margins (k,) of boxes.

    Args:
        tree: whose nodes are joined.
        parents: the cube that each box is in, (k,).
        members: nodes.
        rows: the box that each of them is joined to.
    """
    k = len(parents)
    A, b, c, corners = np.zeros((k, 3, 3)), np.zeros((k, 3)), np.zeros(k), np.zeros((k, 4))
    t = tree.centres[members] - tree.centres[parents[rows]]
    own_b, own_c = moved(tree.A[members], tree.b[members], tree.c[members], t)
    own = tree.corners[members].copy()
    own[:, :3] += own[:, 3:] * t
    np.add.at(A, rows, tree.A[members])
    np.add.at(b, rows, own_b)
    np.add.at(c, rows, own_c)
    np.add.at(corners, rows, own)
    edges = tree.edges[parents][:, None]
    means = corners[:, :3] / np.maximum(corners[:, 3:], 1)
    step, _, margins = place(
        A, (np.einsum("nij,nj->ni", A, means) + b) / edges, "robust", 1.0, ridges=RIDGES
    )
    x = means + step * edges
    area = np.trace(A, axis1=1, axis2=2)
    return x + tree.centres[parents], energies(A, b, c, x), area, margins


def choose(
    tree: Tree, errors: Floats, limit: float, rule: str, boxed: bool = True
) -> tuple[Integers, float]:
    """What each node is joined to, (n,): its parent, the first child in a box, or ALONE; and what all vertices cost.

    A vertex costs its energy and a price. From the finest level up each cube gets the cheapest of: one vertex; one for
    each of the boxes, its halves, quarters and so on, that it is cut into; what its children have.

    Source: Breiman et al. 1984, chapter 3, for trees of given nodes; boxes are a reconstruction.
    """
    price = limit**2 if rule == "total" else 1.0
    leaves = int(tree.starts[-2]) if len(tree.starts) > 1 else 1

    def energy(error: Floats) -> Floats:
        return error**2 if rule == "total" else np.where(error <= limit, 0, np.inf)

    own = energy(errors)
    if rule != "total":
        own[:leaves] = 0
    costs = own + price
    joins = np.full(len(tree.parents), ALONE)
    for level in reversed(range(len(tree.starts) - 1)):
        first, end = int(tree.starts[level]), int(tree.starts[level - 1]) if level else len(costs)
        below = np.arange(tree.starts[level + 1], first)
        up = tree.parents[below] - first
        side = (tree.centres[below] > tree.centres[tree.parents[below]]).astype(np.int64)
        slot = side @ np.array((1, 2, 4))
        children = np.full((end - first, 8), -1)
        children[up, slot] = below
        there = children >= 0
        cost: dict[tuple[int, ...], Floats] = {}
        choice: dict[tuple[int, ...], Integers] = {}
        shapes = sorted(itertools.product((0, 1, 2), repeat=3), key=lambda box: box.count(2))
        for box in shapes:  # of each axis the lower half, the upper one or both
            inside = [k for k in range(8) if all(d in (2, k >> a & 1) for a, d in enumerate(box))]
            if len(inside) == 1:
                cost[box] = np.where(there[:, inside[0]], costs[children[:, inside[0]]], 0)
                continue
            halves = {
                axis: cost[(*box[:axis], 0, *box[axis + 1 :])]
                + cost[(*box[:axis], 1, *box[axis + 1 :])]
                for axis in range(3) if box[axis] == 2
            }  # fmt: skip
            axes = np.array(list(halves))
            each = np.stack(list(halves.values()))
            cost[box], choice[box] = each.min(0), axes[each.argmin(0)]
            one = np.full(end - first, np.inf)
            if len(inside) == 8:
                one = own[first:end] + price
            elif boxed:
                several = there[:, inside].sum(1) > 1
                rows = np.flatnonzero(several)
                where = np.cumsum(several) - 1
                cube, slot = np.nonzero(there[:, inside] & several[:, None])
                members = children[:, inside][cube, slot]
                _, joined, area, _ = solved(tree, first + rows, members, where[cube])
                error = np.sqrt(joined if rule == "total" else joined / np.maximum(area, 1e-30))
                one[rows] = energy(error) + price
            if limit >= 0:
                better = one <= cost[box]
                cost[box] = np.where(better, one, cost[box])
                choice[box] = np.where(better, ALONE, choice[box])
        costs[first:end] = cost[2, 2, 2]
        for cube in range(end - first):
            waiting = [(2, 2, 2)]
            while waiting:
                box = waiting.pop()
                inside = [
                    int(children[cube, k]) for k in range(8)
                    if there[cube, k] and all(d in (2, k >> a & 1) for a, d in enumerate(box))
                ]  # fmt: skip
                if box.count(2) and choice[box][cube] != ALONE:
                    axis = int(choice[box][cube])
                    waiting += [(*box[:axis], half, *box[axis + 1 :]) for half in (0, 1)]
                elif box == (2, 2, 2):
                    joins[inside] = first + cube
                elif len(inside) > 1:
                    joins[inside] = min(inside)
    return joins, float(costs[-1])


def cut(tree: Tree, joins: Integers) -> Integers:
    """The node of each vertex, (vertices,): the largest that its finest cell is joined to."""
    chosen, node = tree.leaves.copy(), tree.leaves
    for _ in range(len(tree.starts) - 1):
        chosen = np.where(joins[node] != ALONE, joins[node], chosen)
        node = tree.parents[node]
    return chosen


def boxes_of(tree: Tree, joins: Integers) -> tuple[Integers, Integers]:
    """The first children of boxes, ascending, and all children in boxes."""
    firsts = np.flatnonzero(joins == np.arange(len(joins)))
    members = np.flatnonzero(np.isin(joins, firsts))
    return firsts, members[tree.parents[members] == tree.parents[joins[members]]]


def depths(tree: Tree, joins: Integers, nodes: Integers, off: Floats) -> Floats:
    """Mean squares of how far steps `off`, (k, 3), lead out of the planes of these nodes or the boxes that they are."""
    A = tree.A.copy()
    firsts, members = boxes_of(tree, joins)
    A[firsts] = 0
    np.add.at(A, joins[members], tree.A[members])
    trace = np.trace(A, axis1=1, axis2=2)[nodes]
    return np.einsum("ni,nij,nj->n", off, A[nodes], off) / np.maximum(trace, 1e-30)


@dataclass(frozen=True)
class Cells:
    """Nodes as a cut uses them: a box's first child stands for the box; a row per node.

    Attributes:
        points: representatives in units of the finest cell edge, (n, 3).
        energies, areas, margins: of their quadrics, (n,).
        edges: how far a representative may be from the mean, (n,).
        boxes: which nodes stand for boxes, (n,) bool.
    """

    points: Floats
    energies: Floats
    areas: Floats
    margins: Floats
    edges: Floats
    boxes: NDArray[np.bool_]


def cells_of(tree: Tree, joins: Integers) -> Cells:
    """The tree's nodes, and the boxes that are joined."""
    points, edges, margins = tree.points.copy(), tree.edges.copy(), tree.margins.copy()
    areas = np.trace(tree.A, axis1=1, axis2=2)
    energy = energies(tree.A, tree.b, tree.c, tree.points - tree.centres)
    firsts, members = boxes_of(tree, joins)
    parents = tree.parents[firsts]
    found = solved(tree, parents, members, np.searchsorted(firsts, joins[members]))
    for kept, of_boxes in zip((points, energy, areas, margins), found, strict=True):
        kept[firsts] = of_boxes
    edges[firsts] = tree.edges[parents]
    return Cells(points, energy, areas, margins, edges, joins == np.arange(len(joins)))
