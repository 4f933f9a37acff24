"""The grid of vertices of each surface, and the tables by which kernels evaluate them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.nurbs_surface import Doubles, NurbsModel
from lodbench.datasets_gen.surfaces import Floats, Indices
from lodbench.kernels.launching import LINE
from lodbench.kernels.nurbs.reference import surface_origin
from lodbench.kernels.nurbs.samples import Numbers, Samples, first_knots

SPAN_FLOATS = 48
SURFACE_WORDS = 16
MOST_RATIO = 1e30  # of neighbouring spans: float32 bears it


@dataclass(frozen=True, eq=False)
class Grid:
    """Vertices of a surface: rows along u, columns along v; vertex (i, j) is number first + i columns + j."""

    u: Samples
    v: Samples
    first: int

    @property
    def rows(self) -> int:
        return len(self.u)

    @property
    def columns(self) -> int:
        return len(self.v)

    @property
    def vertices(self) -> int:
        return self.rows * self.columns

    def triangles(self) -> Indices:
        """Two per cell, row by row, (2 cells, 3) uint32, turning from u to v."""
        corner = self.first + np.arange(self.vertices).reshape(self.rows, self.columns)
        a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
        return np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3).astype(np.uint32)


def placed(samples: Sequence[tuple[Samples, Samples]]) -> list[Grid]:
    """Grids one after the other."""
    grids, first = [], 0
    for u, v in samples:
        grids.append(Grid(u, v, first))
        first += grids[-1].vertices
    return grids


@dataclass(frozen=True, eq=False)
class Tables:
    """What kernels read: see `nurbs/basis.cl` and `nurbs/surface.cl`.

    Attributes:
        surfaces: (m, 16) uint32.
        samples: (n, 4) uint32, of all sides one after the other: u and v of the first surface, and so on.
        places: (2, stride) float32.
        spans: (k, 48) float32.
        octets: (o, 4) uint32.
    """

    surfaces: NDArray[np.uint32]
    samples: NDArray[np.uint32]
    places: Floats
    spans: Floats
    octets: NDArray[np.uint32]

    @property
    def stride(self) -> int:
        """Samples of a plane: all, and a vector more."""
        return self.places.shape[1]


def tables_of(model: NurbsModel, grids: Sequence[Grid]) -> Tables:
    """The tables of a model on these grids."""
    surfaces = np.zeros((len(grids), SURFACE_WORDS), np.uint32)
    rows: list[Numbers] = []
    places: list[Doubles] = []
    records: list[Doubles] = []
    octets: list[Numbers] = []
    sample = record = control = quad = 0
    for s, (surface, grid) in enumerate(zip(model.surfaces, grids, strict=True)):
        starts, span_counts = [], []
        for knots, degree, samples in (
            (surface.knots_u, surface.degree_u, grid.u),
            (surface.knots_v, surface.degree_v, grid.v),
        ):
            begins = first_knots(knots)
            ends = np.searchsorted(samples.spans, samples.spans, "right")
            within = np.arange(len(samples)) - np.searchsorted(samples.spans, samples.spans)
            columns = (
                begins[samples.spans] - degree,
                sample + ends,
                samples.spans,
                record + samples.spans,
            )
            rows.append(np.stack(columns, axis=1))
            places.append(np.stack([samples.t, 1 - samples.t]))
            head = np.flatnonzero(within % LINE == 0)
            counts = np.minimum(LINE, ends[head] - head)
            degrees = np.full(len(head), degree)
            octets.append(
                np.stack([sample + head, counts, record + samples.spans[head], degrees], 1)
            )
            records.append(_span_records(knots, degree, begins))
            starts.append(sample)
            span_counts.append(len(begins))
            sample += len(samples)
            record += len(begins)
        count_u, count_v = surface.points.shape[:2]
        surfaces[s, :11] = (
            grid.first, grid.rows, grid.columns, *starts, control, count_v, surface.degree_u,
            surface.degree_v, quad, span_counts[1],
        )  # fmt: skip
        surfaces[s, 11:14] = surface_origin(surface).view(np.uint32)
        control += count_u * count_v
        quad += span_counts[0] * span_counts[1]
    padded = np.zeros((2, sample + LINE), np.float32)
    padded[:, :sample] = np.concatenate([np.zeros((2, 0)), *places], axis=1)
    none = np.zeros((0, 4), np.int64)
    return Tables(
        surfaces,
        np.concatenate([none, *rows]).astype(np.uint32),
        padded,
        np.concatenate([np.zeros((0, SPAN_FLOATS)), *records]).astype(np.float32),
        np.concatenate([none, *octets]).astype(np.uint32),
    )


def tiles_of(grids: Sequence[Grid], vertices: int) -> NDArray[np.uint32]:
    """Grids cut evenly into tiles of whole rows, about so many vertices each, (n, 3) uint32.

    Each is a surface's number, the first row, how many rows.
    """
    found = [np.zeros((0, 3), np.int64)]
    for s, grid in enumerate(grids):
        down = _cut(grid.rows, -(-grid.rows * grid.columns // vertices))
        found.append(np.column_stack([np.full(len(down), s), down]))
    return np.concatenate(found).astype(np.uint32)


def _cut(count: int, parts: int) -> Numbers:
    """Where each of the even parts begins and how long it is, (parts, 2)."""
    ends = np.arange(min(parts, count) + 1) * count // min(parts, count)
    return np.stack([ends[:-1], np.diff(ends)], axis=1)


def _span_records(knots: Doubles, degree: int, begins: Numbers) -> Doubles:
    """Distances of knots from each span's ends over its width, and the inverse widths of the basis, (spans, 48)."""
    found = np.zeros((len(begins), SPAN_FLOATS))
    width = (knots[begins + 1] - knots[begins])[:, None]
    last = len(knots) - 1
    step = np.arange(8)
    before = knots[np.clip(begins[:, None] - step, 0, last)]
    after = knots[np.clip(begins[:, None] + 1 + step, 0, last)]
    found[:, :8] = np.minimum((knots[begins, None] - before) / width, MOST_RATIO)
    found[:, 8:16] = np.minimum((after - knots[begins + 1, None]) / width, MOST_RATIO)
    for d in range(1, degree + 1):
        r = np.arange(d)
        inverse = 1 / (found[:, r] + 1 + found[:, 7 + d - r])
        found[:, 16 + d * (d - 1) // 2 + r] = inverse
    return found
