"""Which borders of surfaces are one, by exact control points, weights and knots: vertices are welded, normals shared.

```
edge 0  u at its first knot     edge 2  v at its first knot
edge 1  u at its last           edge 3  v at its last
```
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from lodbench.datasets_gen.nurbs_surface import Doubles, NurbsModel, NurbsSurface
from lodbench.kernels.nurbs.grids import Grid
from lodbench.kernels.nurbs.reference import normals_at
from lodbench.kernels.nurbs.samples import Numbers

SMOOTH = np.deg2rad(0.03)
"""Angle between two surfaces' normals up to which a border is smooth there: a few roundings of control points."""
DIGITS = 9  # of knots from 0 to 1, within which two borders' are the same


@dataclass(frozen=True, eq=False)
class Borders:
    """The edges of surfaces, (m, 4) each.

    Attributes:
        owner: the first edge with the same curve, in either direction, as 4 surface + edge.
        turned: the edge runs against its owner.
        collapsed: its control points are one.
    """

    owner: Numbers
    turned: NDArray[np.bool_]
    collapsed: NDArray[np.bool_]

    def counts(self) -> dict[str, int]:
        """Curves by how many edges they have, and those that end in a point."""
        uses = np.bincount(self.owner[~self.collapsed])
        return {
            "shared_edges": int((uses > 1).sum()),
            "open_edges": int((uses == 1).sum()),
            "collapsed_edges": int(self.collapsed.sum()),
        }


def _edges(surface: NurbsSurface) -> list[tuple[int, Doubles, Doubles]]:
    """Degree, knots from 0 to 1, and control points with weights, (n, 4) float32, of each edge."""
    weights = (surface.weights / surface.weights.max())[..., None]
    net = np.concatenate([surface.points, weights], axis=2).astype(np.float32) + np.float32(0)
    sides = [(surface.degree_u, surface.knots_u), (surface.degree_v, surface.knots_v)]
    found = []
    for (degree, knots), rows in zip(
        [sides[1], sides[1], sides[0], sides[0]],
        [net[0], net[-1], net[:, 0], net[:, -1]],
        strict=True,
    ):
        along = (knots - knots[0]) / (knots[-1] - knots[0])
        rows = np.concatenate([rows[:, :3], rows[:, 3:] / rows[:, 3].max()], axis=1)
        found.append((degree, along, rows))
    return found


def borders_of(model: NurbsModel) -> Borders:
    """The borders of a model's surfaces."""
    count = len(model.surfaces)
    owner, turned = np.zeros((count, 4), np.int64), np.zeros((count, 4), bool)
    collapsed = np.zeros((count, 4), bool)
    known: dict[tuple[int, bytes, bytes], tuple[int, bool]] = {}
    for s, surface in enumerate(model.surfaces):
        for e, (degree, knots, rows) in enumerate(_edges(surface)):
            back = np.ascontiguousarray(rows[::-1])
            ways = [
                (degree, (np.round(k, DIGITS) + 0.0).tobytes(), np.ascontiguousarray(r).tobytes())
                for k, r in ((knots, rows), (1 - knots[::-1], back))
            ]
            way = int(ways[1] < ways[0])
            owner[s, e], first_way = known.setdefault(ways[way], (4 * s + e, bool(way)))
            turned[s, e] = bool(way) != first_way
            collapsed[s, e] = (rows[:, :3] == rows[:1, :3]).all()
    return Borders(owner, turned, collapsed)


def edge_vertices(grid: Grid, edge: int) -> Numbers:
    """The vertices of a grid's edge, along the other side."""
    if edge < 2:
        return grid.first + edge * (grid.rows - 1) * grid.columns + np.arange(grid.columns)
    return grid.first + (edge - 2) * (grid.columns - 1) + np.arange(grid.rows) * grid.columns


@dataclass(frozen=True, eq=False)
class Shared:
    """Vertices on edges that are another's place too.

    Attributes:
        vertices: (k,) those that are not the first at their place.
        roots: (k,) the first.
        smooth: (k,) the surface's normal is the same there.
    """

    vertices: Numbers
    roots: Numbers
    smooth: NDArray[np.bool_]


def shared_vertices(
    model: NurbsModel, grids: Sequence[Grid], borders: Borders, normals: bool
) -> Shared:
    """The vertices that coincide, by integers alone and never by position; `normals`: compare those, in float64."""
    pairs = [np.zeros((2, 0), np.int64)]
    for s, grid in enumerate(grids):
        for e in range(4):
            own = edge_vertices(grid, e)
            if borders.collapsed[s, e]:
                pairs.append(np.stack([own[1:], np.full(len(own) - 1, own[0])]))
            o, oe = divmod(int(borders.owner[s, e]), 4)
            other = edge_vertices(grids[o], oe)
            if (o, oe) != (s, e) and len(other) == len(own):
                pairs.append(np.stack([own, other[::-1] if borders.turned[s, e] else other]))
    a, b = np.concatenate(pairs, axis=1)
    vertices, number = np.unique(np.concatenate([a, b]), return_inverse=True)
    number = number.reshape(2, -1)
    size = len(vertices)
    graph = coo_matrix((np.ones(len(a), bool), (number[0], number[1])), (size, size))
    group = connected_components(graph, directed=False)[1]
    first = np.full(size, size)
    np.minimum.at(first, group, np.arange(size))
    root = first[group]
    smooth = np.zeros(size, bool)
    if normals and size:
        unit = _border_normals(model, grids, vertices)
        smooth = np.linalg.norm(unit - unit[root], axis=1) <= SMOOTH
    other = root != np.arange(size)
    return Shared(vertices[other], vertices[root[other]], smooth[other])


def _border_normals(model: NurbsModel, grids: Sequence[Grid], vertices: Numbers) -> Doubles:
    """The surface's own normals at these vertices of edges, (k, 3)."""
    unit = np.zeros((len(vertices), 3))
    for surface, grid in zip(model.surfaces, grids, strict=True):
        for e in range(4):
            own = edge_vertices(grid, e)
            at = np.searchsorted(vertices, own)
            there = at < len(vertices)
            there[there] = vertices[at[there]] == own[there]
            if there.any():
                u, v = grid.u, grid.v
                ends = (u.ends(e == 1), v) if e < 2 else (u, v.ends(e == 3))
                unit[at[there]] = normals_at(surface, *ends)[0].reshape(-1, 3)[there]
    return unit
