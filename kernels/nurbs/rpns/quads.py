"""The KSQuads of a model, the edges that they share, and the tables by which kernels read them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import comb

from lodbench.datasets_gen.nurbs_surface import Doubles, NurbsModel
from lodbench.datasets_gen.surfaces import Floats
from lodbench.kernels.launching import LINE
from lodbench.kernels.nurbs.borders import Borders
from lodbench.kernels.nurbs.grids import Grid
from lodbench.kernels.nurbs.reference import basis
from lodbench.kernels.nurbs.samples import Numbers, Samples, first_knots

DEGREES = 14  # of products of two tangents, 0 to 13
PLACES = 5  # of a curve, at which its length on the screen is taken
HIGH = 4  # lane of `fives` at which a span ends
ALWAYS, COLLAPSED = 2**32 - 1, 2**32 - 2  # as in nurbs/rpns/sampler.cl


@dataclass(frozen=True, eq=False)
class Quads:
    """What kernels read: see `nurbs/rpns/geometry.cl`. KSQuads go surface after surface, v fastest.

    Attributes:
        octets: (o, 8) uint32.
        firsts: (records,) uint32, the first control row of each span of all sides.
        beziers: (records, 64) float32.
        fives: (records, 8, 8) float32, see `nurbs/rpns/curves.cl`.
        by_place: (5, 8, records + 8) float32, see `nurbs/rpns/lengths.cl`.
        choose: (14, 14) float32, binomial coefficients.
        places: (quads, 3) int64: surface, and the numbers of its spans of u and v.
        rows: (quads, 16) uint32, see `nurbs/rpns/sampler.cl`.
        edges: (edges, 8) uint32, likewise.
    """

    octets: NDArray[np.uint32]
    firsts: NDArray[np.uint32]
    beziers: Floats
    fives: Floats
    by_place: Floats
    choose: Floats
    places: Numbers
    rows: NDArray[np.uint32]
    edges: NDArray[np.uint32]


def quads_of(model: NurbsModel, grids: Sequence[Grid], borders: Borders) -> Quads:
    """The tables of a model; `grids` are those of its corners, one segment to a span."""
    octets: list[Numbers] = []
    firsts: list[Numbers] = []
    beziers: list[Doubles] = []
    fives: list[Doubles] = []
    places: list[Numbers] = []
    rows: list[Numbers] = []
    edges: list[Numbers] = []
    record = quad = edge = control = 0
    sides: list[list[Numbers]] = []  # the edges of each surface's borders
    for s, (surface, grid) in enumerate(zip(model.surfaces, grids, strict=True)):
        begins = [first_knots(knots) for knots in (surface.knots_u, surface.knots_v)]
        degrees = surface.degree_u, surface.degree_v
        height, width = (len(b) for b in begins)
        u, v = np.meshgrid(np.arange(height), np.arange(0, width, LINE), indexing="ij")
        u, v = u.ravel(), v.ravel()
        zero = np.zeros_like(u)
        octets.append(
            np.stack(
                [
                    zero + s, begins[0][u] - degrees[0], record + u, record + height + v,
                    np.minimum(LINE, width - v), quad + u * width + v, zero, zero + edge,
                ], axis=1,
            )
        )  # fmt: skip
        for knots, degree, begin in zip(
            (surface.knots_u, surface.knots_v), degrees, begins, strict=True
        ):
            firsts.append(begin - degree)
            beziers.append(_beziers(knots, degree, begin))
            fives.append(_fives(knots, degree, begin))
        i, j = (a.ravel() for a in np.meshgrid(np.arange(height), np.arange(width), indexing="ij"))
        places.append(np.stack([np.full_like(i, s), i, j], axis=1))
        columns = surface.points.shape[1]
        net = control + (begins[0] - degrees[0])[:, None] * columns + (begins[1] - degrees[1])
        across, along = np.arange((height + 1) * width), np.arange((width + 1) * height)
        fixed = edge + across.reshape(height + 1, width)  # u is at a knot
        other = edge + len(across) + along.reshape(width + 1, height).T
        on_border = (i == 0) | (i == height - 1) | (j == 0) | (j == width - 1)
        rows.append(
            np.stack(
                [
                    np.full_like(i, s), net[i, j], record + i, record + height + j, 2 * fixed[i, j],
                    2 * fixed[i + 1, j], 2 * other[i, j], 2 * other[i, j + 1],
                    grid.first + i * grid.columns + j, np.full_like(i, grid.columns), on_border,
                    *np.zeros((5, len(i)), np.int64),
                ], axis=1,
            )
        )  # fmt: skip
        number = quad + np.arange(height * width).reshape(height, width)
        edges += [
            _edges(s, net, record, record + height, number, False),
            _edges(s, net.T, record + height, record, number.T, True),
        ]
        sides.append([fixed[0], fixed[-1], other[:, 0], other[:, -1]])
        record += height + width
        quad += height * width
        edge += len(across) + len(along)
        control += surface.points.shape[0] * columns

    def joined(parts: list[Numbers] | list[Doubles], width: int) -> NDArray:
        return np.concatenate([np.zeros((0, width), np.int64), *parts])

    n = np.arange(DEGREES)
    found = joined(rows, 16), joined(edges, 8)
    _share(*found, sides, borders)
    five = joined(fives, 64).astype(np.float32).reshape(-1, 8, 8)
    return Quads(
        _always(joined(octets, 8), found[1]).astype(np.uint32),
        np.concatenate([np.zeros(0), *firsts]).astype(np.uint32),
        joined(beziers, 64).astype(np.float32),
        five,
        _by_place(five),
        np.asarray(comb(n[:, None], n[None]), np.float32),
        joined(places, 3).astype(np.int64),
        *(rows.astype(np.uint32) for rows in found),
    )


def _edges(
    surface: int, net: Numbers, across: int, along: int, quads: Numbers, by_u: bool
) -> Numbers:
    """All edges at knots of one side, (n, 8), by the KSQuad after each, the last ones by that before.

    Args:
        surface: its number.
        net: first control point of each KSQuad, the side across first.
        across: the first span record of the side that has the knots.
        along: that of the other.
        quads: numbers of the KSQuads.
        by_u: the other side is u.
    """
    count, spans = net.shape
    k, j = (a.ravel() for a in np.meshgrid(np.arange(count + 1), np.arange(spans), indexing="ij"))
    own, before = np.minimum(k, count - 1), np.maximum(k - 1, 0)
    lane = np.where(k == count, HIGH, 0)
    return np.stack(
        [
            np.full_like(k, surface), net[own, j], across + own, along + j, np.full_like(k, by_u),
            lane, quads[before, j], quads[own, j],
        ], axis=1,
    )  # fmt: skip


def _share(rows: Numbers, edges: Numbers, sides: list[list[Numbers]], borders: Borders) -> None:
    """Name the first of edges that are one in place of the others, and say where it runs the other way."""
    name = np.arange(len(edges)) * 2
    for s, owners in enumerate(borders.owner):
        for e, owner in enumerate(owners):
            own = sides[s][e]
            if borders.collapsed[s, e]:
                edges[own, 6] = COLLAPSED
            o, oe = divmod(int(owner), 4)
            theirs = sides[o][oe]
            if (o, oe) == (s, e) or len(own) != len(theirs):
                continue
            turned = bool(borders.turned[s, e])
            name[own] = 2 * (theirs[::-1] if turned else theirs) + turned
            if not borders.collapsed[s, e]:
                edges[theirs, 6] = ALWAYS  # the KSQuads of other surfaces are not among its two
    rows[:, 4:8] = name[rows[:, 4:8] >> 1]


def _always(octets: Numbers, edges: Numbers) -> Numbers:
    """The octets, those marked that have an edge which other surfaces share."""
    shared = edges[edges[:, 6] == ALWAYS, 7]
    octets[np.searchsorted(octets[:, 5], shared, side="right") - 1, 6] = 1
    return octets


def _by_place(fives: Floats) -> Floats:
    """Basis functions by place and control point, (5, 8, records + 8): eight spans one after the other are a vector."""
    found = np.zeros((PLACES, 8, len(fives) + LINE), np.float32)
    found[:, :, : len(fives)] = fives[:, :, :PLACES].transpose(2, 1, 0)
    return found


def _fives(knots: Doubles, degree: int, begins: Numbers) -> Doubles:
    """Basis functions of each span at five places, (spans, 64): control points, then eight lanes.

    Where one span ends and the next begins they are the same numbers.
    """
    t = np.minimum(np.arange(8) / 4, 1.0)
    values = _values(knots, degree, begins, t)
    found = np.zeros((len(begins), 8, 8))
    found[:, : degree + 1] = values.transpose(0, 2, 1)
    for k, moved in enumerate(np.diff(begins)):
        if moved <= degree:
            found[k, :, HIGH:] = 0
            found[k, moved : degree + 1, HIGH:] = found[k + 1, : degree + 1 - moved, :1]
    return found.reshape(-1, 64)


def _values(knots: Doubles, degree: int, begins: Numbers, t: Doubles) -> Doubles:
    """The basis functions that are not zero on each span at places 0..1 of it, (spans, places, degree + 1)."""
    spans = len(begins)
    samples = Samples(np.repeat(np.arange(spans), len(t)), np.tile(t, spans))
    values = basis(knots, degree, samples)[0].reshape(spans, len(t), -1)
    local = begins[:, None] - degree + np.arange(degree + 1)
    return np.take_along_axis(values, local[:, None], axis=2)


def _beziers(knots: Doubles, degree: int, begins: Numbers) -> Doubles:
    """For each span the matrix from its control points to those of the Bezier curve that it is, (spans, 64)."""
    t = np.arange(degree + 1) / degree
    i = np.arange(degree + 1)
    bernstein = comb(degree, i) * t[:, None] ** i * (1 - t[:, None]) ** (degree - i)
    found = np.zeros((len(begins), 8, 8))
    found[:, : degree + 1, : degree + 1] = np.linalg.solve(
        bernstein, _values(knots, degree, begins, t)
    )
    return found.reshape(-1, 64)
