"""Which border curves of patches are one, by exact control points: vertices are welded, normals shared.

```
edge 0  u = 0   corners 0 1        corner 2 [u = 1] + [v = 1]
edge 1  u = 1   corners 2 3
edge 2  v = 0   corners 0 2
edge 3  v = 1   corners 1 3
```
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from lodbench.datasets_gen.surfaces import Floats
from lodbench.kernels.bezier.lattice import edge_vertices, side_vertices
from lodbench.kernels.bezier.reference import Doubles, normals_at

Numbers = NDArray[np.int64]
Flags = NDArray[np.bool_]
ENDS = np.array([(0, 1), (2, 3), (0, 2), (1, 3)])
"""The corners at which each edge begins and ends."""
SMOOTH = np.deg2rad(0.03)
"""Angle between two patches' normals up to which their border is smooth: a few float32 roundings of control points, and
a quarter of what a normal may be off."""
SAMPLES = 8  # segments of a border at whose inner ends its normals are compared


@dataclass(frozen=True, eq=False)
class Borders:
    """The edges of patches, (m, 4) each.

    Attributes:
        curve: number of the edge's curve; edges with the same control points, in either direction, have the same.
        turned: the edge runs against its curve.
        collapsed: its control points are one.
        smooth: its curve is that of other edges too, and all normals along it agree with those of the first of these.
        corner: (m, 4 corners) number of the corner point: one where edges that are one end.
        corner_owner: (m, 4 corners) the corner, as 4 patch + corner, whose normal this one has.
        owner: the first edge of the same curve, as 4 patch + edge.
    """

    curve: Numbers
    turned: Flags
    collapsed: Flags
    smooth: Flags
    corner: Numbers
    corner_owner: Numbers
    owner: Numbers

    def counts(self) -> dict[str, int]:
        """Curves by how many edges they have, those that end in nothing, and those that are smooth."""
        uses = np.bincount(self.curve[~self.collapsed])
        return {
            "shared_edges": int((uses > 1).sum()),
            "open_edges": int((uses == 1).sum()),
            "collapsed_edges": int(self.collapsed.sum()),
            "smooth_edges": int(self.smooth.sum()),
        }


def _edges(points: Floats) -> Floats:
    """The control points of every patch's edges, (m, 4 edges, 4, 3), without negative zeros."""
    sides = [points[:, 0], points[:, 3], points[:, :, 0], points[:, :, 3]]
    return np.stack(sides, axis=1) + np.float32(0)


def _numbered(rows: Floats) -> tuple[Numbers, Numbers]:
    """The number of each row's value among all that there are, and the first row of each value, (n,) both."""
    words = np.ascontiguousarray(rows).view(np.dtype((np.void, 4 * rows.shape[1]))).ravel()
    _, first, number = np.unique(words, return_index=True, return_inverse=True)
    return number.reshape(-1).astype(np.int64), first[number].reshape(-1).astype(np.int64)


def _joined(count: int, pairs: list[tuple[Numbers, Numbers]]) -> Numbers:
    """The component of each of `count` nodes when pairs of them are joined."""
    a, b = (np.concatenate(ends) for ends in zip(*pairs, strict=True))
    graph = coo_matrix((np.ones(len(a), bool), (a, b)), (count, count))
    return connected_components(graph, directed=False)[1].astype(np.int64)


def borders_of(points: Floats) -> Borders:
    """The borders of patches, (m, 4, 4, 3) float32."""
    edges = _edges(points)
    count = len(edges)
    forward = edges.reshape(-1, 12)
    backward = edges[:, :, ::-1].reshape(-1, 12)
    differs = forward != backward
    first = differs.argmax(axis=1)[:, None]
    turned = np.take_along_axis(backward < forward, first, axis=1)[:, 0]
    curve, owner = _numbered(np.where(turned[:, None], backward, forward))
    collapsed = (edges == edges[:, :, :1]).all(axis=(2, 3))

    ends = (4 * np.arange(count)[:, None, None] + ENDS).reshape(-1, 2)
    ends = np.where(turned[:, None], ends[:, ::-1], ends)
    loops = ~differs.any(axis=1)  # back the way it came, or a point
    own = [(ends[loops, 0], ends[loops, 1])]
    drawn = ~collapsed.ravel()  # points that coincide make no neighbours
    corner = _joined(4 * count, own + [(ends[drawn, k], ends[owner[drawn], k]) for k in range(2)])

    smooth, at_corner = _smooth(points.astype(np.float64), turned, owner, ends)
    smooth &= drawn & (owner != np.arange(4 * count))
    met = [
        (ends[both, k], ends[owner[both], k])
        for k in range(2)
        for both in [np.flatnonzero(smooth & at_corner[:, k])]
    ]
    corner_group = _joined(4 * count, met)
    least = np.full(4 * count, 4 * count)
    np.minimum.at(least, corner_group, np.arange(4 * count))
    shape = count, 4
    return Borders(
        curve.reshape(shape),
        turned.reshape(shape),
        collapsed,
        smooth.reshape(shape),
        corner.reshape(shape),
        least[corner_group].reshape(shape),
        owner.reshape(shape),
    )


def _smooth(P: Doubles, turned: Flags, owner: Numbers, ends: Numbers) -> tuple[Flags, Flags]:
    """Do normals along each edge agree with those of its owner, (4 m,), and at each end, (4 m, 2)?"""
    t = np.arange(SAMPLES + 1) / SAMPLES
    zero = np.zeros_like(t)
    sides = [(zero, t), (zero + 1, t), (t, zero), (t, zero + 1)]
    found = [normals_at(P, u, v)[0] for u, v in sides]
    normals = np.stack(found, axis=1).reshape(-1, SAMPLES + 1, 3)
    normals = np.where(turned[:, None, None], normals[:, ::-1], normals)
    apart = np.linalg.norm(normals - normals[owner], axis=-1)
    return (apart[:, 1:-1] <= SMOOTH).all(axis=1), apart[:, [0, -1]] <= SMOOTH


def sharing(borders: Borders, level: int) -> tuple[NDArray[np.uint32], int]:
    """Which virtual vertices are one, by integers alone: (curve, place on it) and never by position.

    Returns:
        The welded vertex of every patch's vertex, (m, (n + 1)^2) uint32, and how many there are: corners first, then
        curve after curve, then interior after interior.
    """
    side, n = side_vertices(level), 1 << level
    count = len(borders.curve)
    welded = np.empty((count, side * side), np.int64)
    places = edge_vertices(level)
    corners, corner = np.unique(borders.corner, return_inverse=True)
    corner = corner.reshape(count, 4)
    total = len(corners)
    drawn = ~borders.collapsed
    curves, curve = np.unique(borders.curve[drawn], return_inverse=True)
    number = np.zeros((count, 4), np.int64)
    number[drawn] = curve.reshape(-1)
    step = np.arange(1, n)
    for edge in range(4):
        along = np.where(borders.turned[:, edge, None], n - step, step)
        own = total + number[:, edge, None] * (n - 1) + along - 1
        point = corner[:, ENDS[edge, 0], None]
        welded[:, places[edge, 1:-1]] = np.where(drawn[:, edge, None], own, point)
    welded[:, [0, n, n * side, n * side + n]] = corner
    total += len(curves) * (n - 1)
    inside = np.arange(side * side).reshape(side, side)[1:-1, 1:-1].ravel()
    last = total + count * len(inside)
    welded[:, inside] = np.arange(total, last).reshape(count, len(inside))
    return welded.astype(np.uint32), last


def seams(borders: Borders, level: int) -> Numbers:
    """Vertices that have another's normal, (k, 4): patch and virtual vertex, and patch and vertex of the other.

    Along a smooth border these are those of the first patch of all that meet there.
    """
    side, n = side_vertices(level), 1 << level
    places = edge_vertices(level)
    patch, edge = np.nonzero(borders.smooth)
    other, other_edge = np.divmod(borders.owner[patch, edge], 4)
    step = np.arange(1, n)
    against = borders.turned[patch, edge] != borders.turned[other, other_edge]
    there = np.where(against[:, None], n - step, step)
    columns = [
        np.repeat(patch, n - 1),
        places[edge][:, 1:-1].ravel(),
        np.repeat(other, n - 1),
        np.take_along_axis(places[other_edge], there, axis=1).ravel(),
    ]
    along = np.stack(columns, axis=1)
    vertices = np.array([0, n, n * side, n * side + n])
    own = np.arange(borders.corner_owner.size).reshape(-1, 4)
    patch, corner = np.nonzero(borders.corner_owner != own)
    other, other_corner = np.divmod(borders.corner_owner[patch, corner], 4)
    at_corners = np.stack([patch, vertices[corner], other, vertices[other_corner]], axis=1)
    return np.concatenate([along, at_corners])
