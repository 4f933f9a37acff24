"""A clustered mesh whose edges have two triangles each: sheets that met in a cell part again, each with a vertex there.

The boundary of the triangles' chain is that of the input, so that on a closed, oriented input every edge of the output
has as many triangles on one side as on the other. Where it has more than one of each, they are paired around the edge,
solid by solid; corners that pairs join are a fan, and each fan has a vertex of its own, all at the same place to the
bit. Two triangles that back each other and touch nothing else go. What has no partner, as at a border, stays open. All
of this happens where triangles around a vertex are not one fan already (`links.py`), so nothing else is looked at.

Source: none, a reconstruction after Gueziec et al. 2001, Cutting and stitching: converting sets of polygons to manifold
surfaces.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from lodbench.kernels.cluster import turned

Index = NDArray[np.intp]
_ROUNDS = 64  # each parts at least one fan wherever an edge is left that is not manifold


@dataclass(frozen=True)
class Parted:
    """Which triangles stay, and the fan of each of their corners.

    Attributes:
        rows: (k,) the triangles that stay, ascending.
        fans: (k, 3) the fan of each corner; corners of one fan have one vertex. A vertex that is sound has the fan of
            its own number, those of others follow.
    """

    rows: Index
    fans: Index


def part(
    positions: NDArray[np.floating],
    triangles: NDArray[np.integer],
    troubled: NDArray[np.bool_] | None = None,
) -> Parted:
    """The fans of a mesh's corners.

    Args:
        positions: (n, 3).
        triangles: (m, 3), none with a corner twice.
        troubled: (n,), vertices around which triangles are not one fan, and any others; None: all.
    """
    whole = np.asarray(triangles, np.intp).reshape(-1, 3)
    if troubled is None:
        troubled = np.ones(len(positions), bool)
    asked = troubled[whole]
    looked = np.flatnonzero(asked[:, 0] | asked[:, 1] | asked[:, 2])
    corners, asked = whole[looked], asked[looked]
    found = _fans_of(positions, corners)
    fans = whole.copy()
    fans[looked] = np.where(asked, len(positions) + found, corners)
    keys = turned.keys(fans[looked], int(fans.max(initial=-1)) + 1)
    _, which, uses = np.unique(keys, return_inverse=True, return_counts=True)
    stays = np.ones(len(whole), bool)
    stays[looked] = uses[which.reshape(-1)] == 1
    rows = np.flatnonzero(stays)
    return Parted(rows, fans[rows])


def _fans_of(positions: NDArray[np.floating], corners: Index) -> Index:
    """The fan of each corner, (m, 3), from 0, in the order of the fans' first corners."""
    begin, end = corners.reshape(-1), np.roll(corners, -1, axis=1).reshape(-1)
    low, high = np.minimum(begin, end), np.maximum(begin, end)
    forward = begin == low
    order = np.argsort(
        low.astype(np.uint64) << np.uint64(32) | high.astype(np.uint64), kind="stable"
    )
    first = np.r_[True, (low[order[1:]] != low[order[:-1]]) | (high[order[1:]] != high[order[:-1]])]
    starts = np.flatnonzero(first)
    sizes = np.diff(np.r_[starts, len(order)]) if len(order) else starts
    partner = np.full(len(order), -1, np.intp)
    plain = starts[sizes == 2]
    plain = plain[forward[order[plain]] != forward[order[plain + 1]]]
    _join(partner, order[plain], order[plain + 1])
    many = np.flatnonzero(np.repeat(sizes > 2, sizes))
    half = order[many]
    angles = _angles(positions, corners, half, low[half], high[half])
    around = np.lexsort(
        (half, forward[half], angles, np.repeat(np.arange(len(sizes)), sizes)[many])
    )
    _pair(partner, half[around], sizes[sizes > 2], forward)
    fans = _fans(partner, len(corners))
    for _ in range(_ROUNDS):
        if not _swap(partner, fans, forward):
            break
        fans = _fans(partner, len(corners))
    return fans


def _join(partner: Index, a: Index, b: Index) -> None:
    partner[a], partner[b] = b, a


def _angles(
    positions: NDArray[np.floating], corners: Index, half: Index, low: Index, high: Index
) -> NDArray[np.float64]:
    """Where the triangles of half-edges stand around their edge, as seen along it from `low` to `high`, radians."""
    start = positions[low].astype(np.float64)
    along = positions[high] - start
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
    out = positions[corners[half // 3, (half % 3 + 2) % 3]] - start
    x = np.cross(along, np.eye(3)[np.abs(along).argmin(axis=1)])
    y = np.cross(along, x)
    return np.arctan2((out * y).sum(axis=1), (out * x).sum(axis=1))


def _pair(partner: Index, around: Index, sizes: Index, forward: NDArray[np.bool_]) -> None:
    """Pair half-edges so that what is solid lies between: backward, then the next forward around their edge.

    The outside of a triangle that runs along the edge is ahead of it around the edge, that of one that runs against it
    is behind.

    Args:
        partner: of each half-edge; filled in.
        around: half-edges, edge by edge, in their order around it.
        sizes: how many each edge has.
        forward: of each half-edge, does it run along its edge?
    """
    along, ends = forward[around].tolist(), np.cumsum(sizes).tolist()
    begin, pairs = 0, []
    for end in ends:
        waiting: list[int] = []
        alone: list[int] = []
        for row in range(begin, end):
            if not along[row]:
                waiting.append(row)
            elif waiting:
                pairs.append((waiting.pop(), row))
            else:
                alone.append(row)
        pairs += zip(reversed(waiting), alone, strict=False)  # around the start of the angles
        begin = end
    a, b = around[np.array(pairs, np.intp).reshape(-1, 2)].T
    _join(partner, a, b)


def _fans(partner: Index, count: int) -> Index:
    """The fan of each corner, (count, 3): what pairs of half-edges join."""
    here = np.flatnonzero(partner >= 0)
    here = here[here < partner[here]]
    there = partner[here]
    following, after = (e // 3 * 3 + (e % 3 + 1) % 3 for e in (here, there))
    a, b = np.concatenate([here, following]), np.concatenate([after, there])
    graph = coo_array((np.ones(len(a), np.int8), (a, b)), shape=(3 * count, 3 * count))
    return connected_components(graph, directed=False)[1].astype(np.intp).reshape(count, 3)


def _swap(partner: Index, fans: Index, forward: NDArray[np.bool_]) -> bool:
    """Part fans that meet twice along an edge, by changing partners there; False where none do.

    Two pairs with the same fans at both ends become two edges: at each end the one cycle of triangles becomes two.
    """
    begin, end = fans.reshape(-1), np.roll(fans, -1, axis=1).reshape(-1)
    rows = np.flatnonzero(forward & (partner >= 0))
    keys = begin[rows].astype(np.uint64) << np.uint64(32) | end[rows].astype(np.uint64)
    order = np.argsort(keys, kind="stable")
    twice = np.flatnonzero(keys[order[1:]] == keys[order[:-1]])
    touched: set[int] = set()
    for at in twice:
        a, b = int(rows[order[at]]), int(rows[order[at + 1]])
        ends = {int(begin[a]), int(end[a])}
        if ends & touched:
            continue
        touched |= ends
        other, another = partner[a], partner[b]
        _join(partner, np.array([a, b]), np.array([another, other]))
    return bool(len(twice))
