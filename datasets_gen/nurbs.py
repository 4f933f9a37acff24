"""NURBS models that are made: conics, sheets of any degrees, a closed body of many surfaces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.nurbs_surface import NurbsModel, NurbsSurface, cut

_CIRCLE = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)])
_CIRCLE_WEIGHTS = np.array([1, 0.5**0.5] * 4 + [1])
_CIRCLE_KNOTS = np.array([0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4], np.float64)


def cylinder(radius: float = 1.0, height: float = 2.0) -> NurbsModel:
    """An exact cylinder about z, one rational surface of degree 2 x 1, open at both ends."""
    ring = np.column_stack([radius * _CIRCLE, np.zeros(9)])
    points = np.stack([ring, ring + np.array([0, 0, height])], axis=1)
    weights = np.repeat(_CIRCLE_WEIGHTS[:, None], 2, axis=1)
    return NurbsModel((NurbsSurface(2, 1, _CIRCLE_KNOTS, [0, 0, 1, 1], points, weights),))


def ball() -> NurbsModel:
    """An exact unit sphere, one rational surface of degree 2 x 2 with collapsed edges at both poles."""
    half = np.array([(0, -1), (1, -1), (1, 0), (1, 1), (0, 1)])
    weights = np.array([1, 0.5**0.5, 1, 0.5**0.5, 1])
    flat = _CIRCLE[:, None] * half[None, :, :1]
    points = np.concatenate([flat, np.broadcast_to(half[None, :, 1:], (9, 5, 1))], axis=2)
    knots = [0, 0, 0, 1, 1, 2, 2, 2]
    total = _CIRCLE_WEIGHTS[:, None] * weights[None]
    return NurbsModel((NurbsSurface(2, 2, _CIRCLE_KNOTS, knots, points, total),))


def quilt(rows: int, columns: int, spans: int, seed: int = 0) -> NurbsModel:
    """An open wavy sheet of rows * columns bicubic surfaces of spans x spans knot spans, without cracks.

    Neighbours have the same control points on the edge that they share. All weights are 1.
    """
    knots = np.concatenate([np.zeros(3), np.arange(spans + 1), np.full(3, spans)]) / spans
    places = np.lib.stride_tricks.sliding_window_view(knots[1:-1], 3).mean(axis=1)
    places[[0, -1]] = 0.0, 1.0  # exactly, so that neighbours agree to the bit
    random = np.random.default_rng(seed)
    waves = random.normal(0, 2, (6, 2))
    shifts = random.uniform(0, 2 * np.pi, 6)

    def points(row: int, column: int) -> NDArray[np.float64]:
        x, y = np.meshgrid(column + places, row + places, indexing="ij")
        z = sum(0.08 * np.sin(a * x + b * y + c) for (a, b), c in zip(waves, shifts, strict=True))
        return np.stack([x, y, np.asarray(z)], axis=2)

    ones = np.ones((spans + 3, spans + 3))
    return NurbsModel(
        tuple(
            NurbsSurface(3, 3, knots, knots, points(row, column), ones)
            for row in range(rows)
            for column in range(columns)
        )
    )


def torus(radius: float = 1.0, tube: float = 0.4) -> NurbsModel:
    """An exact torus about z, one rational surface of degree 2 x 2, closed both ways."""
    around = np.column_stack([_CIRCLE, np.zeros(9)])
    ring = np.column_stack([radius + tube * _CIRCLE[:, 0], tube * _CIRCLE[:, 1]])
    points = around[:, None] * ring[None, :, :1] + (0, 0, 1) * ring[None, :, 1:]
    weights = np.outer(_CIRCLE_WEIGHTS, _CIRCLE_WEIGHTS)
    return NurbsModel((NurbsSurface(2, 2, _CIRCLE_KNOTS, _CIRCLE_KNOTS, points, weights),))


def mixed_degrees(seed: int = 0) -> NurbsModel:
    """Seven wavy sheets of degrees 1 x 7, 2 x 6 ... 7 x 1 in a row, uneven repeated knots and weights."""
    random = np.random.default_rng(seed)
    surfaces = []
    for degree in range(1, 8):
        degrees = degree, 8 - degree
        knots = [_uneven_knots(p, random) for p in degrees]
        places = [
            np.lib.stride_tricks.sliding_window_view(k[1:-1], p).mean(axis=1)
            for k, p in zip(knots, degrees, strict=True)
        ]
        x, y = np.meshgrid(*places, indexing="ij")
        z = 0.2 * np.sin(5 * x + degree) * np.cos(4 * y) + random.normal(0, 0.01, x.shape)
        points = np.stack([x + 1.2 * degree, y, z], axis=2)
        weights = random.uniform(0.5, 2, x.shape)
        surfaces.append(NurbsSurface(degrees[0], degrees[1], knots[0], knots[1], points, weights))
    return NurbsModel(tuple(surfaces))


def sheets(degree: int, count: int = 256, seed: int = 0) -> NurbsModel:
    """So many wavy sheets of one degree in both directions, uneven repeated knots; all weights are 1."""
    random = np.random.default_rng(seed)
    knots = [_uneven_knots(degree, random) for _ in range(2)]
    places = [np.lib.stride_tricks.sliding_window_view(k[1:-1], degree).mean(axis=1) for k in knots]
    x, y = np.meshgrid(*places, indexing="ij")
    side = round(count**0.5)
    return NurbsModel(
        tuple(
            NurbsSurface(
                degree, degree, knots[0], knots[1],
                np.stack([x + 1.2 * (k % side), y + 1.2 * (k // side), np.sin(5 * x + k) * 0.2], 2),
            )
            for k in range(count)
        )
    )  # fmt: skip


def random_spans(count: int = 25, spans: int = 20, seed: int = 7) -> NurbsModel:
    """So many wavy sheets of spans x spans KSQuads, of random degrees 1 to 4, knots, repeated ones among them, heights
    and places; every other one has random weights.
    """
    random = np.random.default_rng(seed)
    surfaces = []
    for k in range(count):
        degrees = [int(degree) for degree in random.integers(1, 5, 2)]
        knots = []
        for p in degrees:
            inner = np.sort(random.uniform(0, 1, spans - 1)).repeat(
                random.integers(1, p + 1, spans - 1)
            )
            knots.append(np.concatenate([np.zeros(p + 1), inner, np.ones(p + 1)]))
        shape = tuple(len(x) - p - 1 for x, p in zip(knots, degrees, strict=True))
        x, y = np.meshgrid(*(np.linspace(-1, 1, n) for n in shape), indexing="ij")
        z = random.normal(0, 0.3, shape) * 0.15 * random.random()
        points = np.stack([x, y, z], 2) + random.normal(0, 2, 3)
        weights = random.uniform(0.3, 3, shape) if k % 2 else None
        surfaces.append(NurbsSurface(degrees[0], degrees[1], knots[0], knots[1], points, weights))
    return NurbsModel(tuple(surfaces))


def _uneven_knots(degree: int, random: np.random.Generator) -> NDArray[np.float64]:
    """Clamped from 0 to 1, five inner knots of which the second stands there as often as the degree allows."""
    inner = np.sort(random.uniform(0.05, 0.95, 5)).repeat([1, degree, 1, 1, 1])
    return np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])


def body(rows: int = 8, columns: int = 11, spans: tuple[int, int] = (12, 11)) -> NurbsModel:
    """A closed bumpy ring of rows x columns bicubic surfaces, smooth, cut out of one periodic spline.

    Each has so many knot spans around the tube and along the ring; all weights are 1.
    """
    sides = rows * spans[0], columns * spans[1]
    nets = [np.arange(-1, side + 2) * 2 * np.pi / side for side in sides]
    a, b = np.meshgrid(*nets, indexing="ij")
    thick = (
        0.35 + 0.08 * np.sin(3 * b) + 0.04 * np.cos(4 * a + 2 * b) + 0.015 * np.sin(9 * a - 7 * b)
    )
    out = 1 + thick * np.cos(a)
    net = np.stack(
        [out * np.cos(b), (1 + 0.3 * np.sin(b)) * out * np.sin(b), -thick * np.sin(a)], 2
    )
    for axis, side in enumerate(sides):  # to the bit: rows past the end are those of the beginning
        net = np.moveaxis(net, axis, 0)
        net[side:] = net[:3]
        net = np.moveaxis(net, 0, axis)
    knots = [np.arange(-3.0, side + 4) for side in sides]
    surfaces = []
    for row in range(rows):
        along_u, strip = cut(knots[0], net, 3, row * spans[0], (row + 1) * spans[0])
        for column in range(columns):
            ends = column * spans[1], (column + 1) * spans[1]
            along_v, points = cut(knots[1], np.moveaxis(strip, 1, 0), 3, *ends)
            points = np.moveaxis(points, 0, 1)
            surfaces.append(NurbsSurface(3, 3, along_u - along_u[0], along_v - along_v[0], points))
    return NurbsModel(tuple(surfaces))
