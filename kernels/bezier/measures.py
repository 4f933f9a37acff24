"""The local tests in float64: what is measured of a candidate, and what the edges of a coarse triangle insert."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Floats
from lodbench.kernels.bezier.adaptive_params import AdaptiveParams
from lodbench.kernels.bezier.candidates import (
    CELL,
    COLUMN,
    DEEPEST,
    EDGE_NODES,
    INSIDE,
    NODES,
    ROW,
    SAMPLES,
    Flags,
    Integers,
    cell_samples,
)
from lodbench.kernels.bezier.lattice import edge_vertices, lattice_parameters, side_vertices
from lodbench.kernels.bezier.reference import Doubles, bernstein_slopes, normals_at, points_at
from lodbench.kernels.system import View

TESTS = {"distance": 0, "flat": 1, "length": 2, "mean": 3}  # TEST of measures.cl but for the last
SCREEN = 1024.0  # pixels of the diagonal where there is no view: the height of the thesis's image
ALONG = np.arange(1, CELL)
HALF = ALONG & -ALONG
MOST_OF_LEVEL = (0, 0x10, 0x54, 0xFE)  # places 1 to 7 on an edge, by the finest level


def inverse_diagonal(points: Floats) -> float:
    """One over the diagonal of the patches' box, (m, 4, 4, 3); what float32 can hold of it."""
    box = points.reshape(-1, 3).astype(np.float64)
    size = float(np.linalg.norm(np.ptp(box, axis=0))) if len(box) else 1.0
    return 1 / max(size, 1e-37) if size else 1.0


def screen_rows(view: View | None, inverse: float) -> Doubles:
    """Four columns, of x, y, z and 1, that bring a point to pixels times w, and to w: (4, 4), of size near 1.

    Without a view pixels are shares of the diagonal.
    """
    if view is None:
        return np.diag([SCREEN * inverse] * 3 + [1.0])
    clip = np.asarray(view.world_to_clip, np.float64)
    rows = np.stack([clip[0] * view.width / 2, clip[1] * view.height / 2, 0 * clip[0], clip[3]])
    unit = np.abs(rows[3, :3]).max() / inverse  # of w, over a diagonal; parallel views have none
    return rows.T / (unit or float(np.abs(rows[3]).max()) or 1.0)


def _projected(points: Doubles, screen: Doubles) -> Doubles:
    rows = points @ screen[:3] + screen[3]
    return rows[..., :3] / np.maximum(rows[..., 3:], 1e-6)


@dataclass(frozen=True, eq=False)
class Measures:
    """How much each candidate of some patches asks to be inserted, the cells of a patch row after row.

    Attributes:
        bends: (m, cells, 6) the most that places 2, 4 and 6 of each edge ask: a b, b c, c d, d a, a c, b d.
        edges: (m, cells, 6, 7) what places 1 to 7 of each ask.
        inside: (m, cells, 12, nodes) what nodes inside ask, by way.
    """

    bends: Doubles
    edges: Doubles
    inside: Doubles


EDGES = ((0, 72), (72, 80), (80, 8), (8, 0), (0, 80), (72, 8))  # as samples at their ends
_OF_TRIANGLE = (  # by way // 3: its three edges in turn, and do they run against it?
    ((0, 0), (1, 0), (4, 1)), ((4, 0), (2, 0), (3, 0)), ((0, 0), (5, 0), (3, 0)), ((1, 0), (2, 0), (5, 1)),
)  # fmt: skip


def measured(P: Doubles, params: AdaptiveParams, inverse: float, screen: Doubles) -> Measures:
    """What the tests measure of patches, (m, 4, 4, 3).

    Source: Concheiro 2013, section 3.2.2, for the names of the tests; the measures are reconstructions. On a border of
    the patch "flat" compares the tangents of the border, which its neighbour has too.
    """
    level = params.base + DEEPEST
    where = cell_samples(level)
    u, v = lattice_parameters(level)
    tangents = []
    if params.test == "flat":
        values = normals_at(P, u, v)[0]
        tangents = _tangents(P * inverse, level)
    elif params.test == "distance":
        values = points_at(P, u, v) * inverse
    else:
        values = _projected(points_at(P, u, v), screen)

    def asked(one: Integers, other: Integers, middle: Integers, share: Doubles) -> Doubles:
        a, b = values[:, where[:, one]], values[:, where[:, other]]
        if params.test == "flat":
            return np.maximum(1 - (a * b).sum(-1), 0)
        if params.test == "distance":
            a, b = a + (b - a) * share[..., None], values[:, where[:, middle]]
        return np.linalg.norm(a - b, axis=-1)

    edges = np.empty((len(P), len(where), len(EDGES), CELL - 1))
    for number, (first, last) in enumerate(EDGES):
        step = (last - first) // CELL
        one, other, middle = (first + step * k for k in (ALONG - HALF, ALONG + HALF, ALONG))
        edges[:, :, number] = asked(one, other, middle, np.full(len(ALONG), 0.5))
        for border, tangent in zip(edge_vertices(level), tangents, strict=True) if tangents else ():
            place = np.full(side_vertices(level) ** 2, -1)
            place[border] = np.arange(len(border))
            on = (place[where[:, [first, last]]] >= 0).all(axis=1)
            a, b = (tangent[:, place[where[on][:, ends]]] for ends in (one, other))
            has_both = ((a * a).sum(-1) > 0.5) & ((b * b).sum(-1) > 0.5)
            edges[:, on, number] = np.where(has_both, np.maximum(1 - (a * b).sum(-1), 0), 0)
    reach = COLUMN & -COLUMN
    end = np.minimum(COLUMN + reach, ROW)
    own = np.arange(NODES)
    one, other, middle = (SAMPLES[:, k] for k in (own - reach, own + end - COLUMN, own))
    share = reach / np.maximum(end - COLUMN + reach, 1)
    inside = np.where(INSIDE, asked(one, other, middle, share), -np.inf)
    return Measures(edges[..., 1::2].max(axis=-1), edges, inside)


def _tangents(P: Doubles, level: int) -> list[Doubles]:
    """Unit tangents of each border, (m, n + 1, 3) each; zeros where there is none."""
    t = np.arange(side_vertices(level)) / (side_vertices(level) - 1)
    found = []
    for border in (P[:, 0], P[:, 3], P[:, :, 0], P[:, :, 3]):
        slope = np.einsum("ni,mik->mnk", bernstein_slopes(t), np.diff(border, axis=1))
        length = np.linalg.norm(slope, axis=-1, keepdims=True)
        found.append(slope / np.where(length > 1e-15, length, np.inf))
    return found


def chosen_ways(measures: Measures) -> Integers:
    """The ways of both triangles of each cell, (m, cells, 2): cut along the diagonal that bends less, rows along the
    edge that does.

    Source: a reconstruction; the thesis has a coarse mesh of its own.
    """
    bends = measures.bends
    flips = 2 * (bends[..., 4] > bends[..., 5]).astype(np.int64)
    found = []
    for triangle in (0, 1):
        kind = flips + triangle
        own = np.stack([_sides(bends[..., None], k)[..., 0] for k in range(4)], axis=-2)
        a, b, c = np.moveaxis(np.take_along_axis(own, kind[..., None, None], -2)[..., 0, :], -1, 0)
        found.append(3 * kind + np.where((b <= a) & (b <= c), 0, np.where(c <= a, 1, 2)))
    return np.stack(found, axis=-1)


def _sides(edges: NDArray, kind: int) -> NDArray:
    """The three edges of a triangle in turn, (..., 3, 7), of those of its cell, (..., 6, 7)."""
    found = [
        edges[..., e, ::-1] if against else edges[..., e, :] for e, against in _OF_TRIANGLE[kind]
    ]
    return np.stack(found, axis=-2)


def way_bends(measures: Measures) -> Doubles:
    """What a way keeps small, (m, cells, 12, 2): the bend of its base, and of the diagonal that it is cut along."""
    found = []
    for way in range(12):
        base = _OF_TRIANGLE[way // 3][(way + 1) % 3][0]
        found.append(measures.bends[..., [base, 4 + way // 6]])
    return np.stack(found, axis=-2)


def passes(measures: Measures, ways: Integers, least: float) -> tuple[Flags, Flags]:
    """Which candidates of coarse triangles, whose ways are (m, cells, 2), pass by themselves.

    Returns:
        Places 1 to 7 on left, right and base, (m, cells, 2, 3, 7), and nodes, (m, cells, 2, nodes).
    """
    every = []
    for way in range(12):
        a, b, c = np.moveaxis(_sides(measures.edges, way // 3), -2, 0)
        turned = (a, b, c)[way % 3], (b, c, a)[way % 3], (c, a, b)[way % 3]
        every.append(np.stack([turned[0], turned[2][..., ::-1], turned[1]], axis=-2))
    edges = np.take_along_axis(np.stack(every, axis=2), ways[..., None, None], axis=2)
    inside = np.take_along_axis(measures.inside, ways[..., None], axis=2)
    return edges >= least, inside >= least


def on_edges(passing: Flags, depth: int) -> Flags:
    """What is inserted on edges, (..., nodes), of what passes there, (..., 3, 7), with the corners.

    With a vertex those between which it lies are inserted, whether they pass or not, since a curve may cross its chord
    there (a reconstruction).
    """
    made = np.zeros((*passing.shape[:-1], CELL + 1), bool)
    made[..., 1:-1] = passing & (MOST_OF_LEVEL[depth] >> ALONG & 1).astype(bool)
    for step in (1, 2):
        for middle in range(2 * step, CELL, 4 * step):
            made[..., middle] |= made[..., middle - step] | made[..., middle + step]
    made[..., [0, -1]] = True
    flags = np.zeros((*passing.shape[:-2], NODES), bool)
    for edge in range(3):
        flags[..., EDGE_NODES[edge]] |= made[..., edge, :]
    return flags


def edge_levels(flags: Flags) -> Integers:
    """The finest level on the left, the right and the base, (..., 3), of flags of nodes, (..., nodes)."""
    along = flags[..., EDGE_NODES]
    found = [along[..., 4], along[..., 2] | along[..., 6], along[..., 1::2].any(axis=-1)]
    return np.max([(k + 1) * level for k, level in enumerate(found)], axis=0)
