"""The KSQuads of a model, and the tables by which the geometry stage reads them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import comb

from lodbench.datasets_gen.nurbs_surface import Doubles, NurbsModel
from lodbench.datasets_gen.surfaces import Floats
from lodbench.kernels.launching import LINE
from lodbench.kernels.nurbs.grids import Grid
from lodbench.kernels.nurbs.reference import basis
from lodbench.kernels.nurbs.samples import Numbers, Samples, first_knots

DEGREES = 14  # of products of two tangents, 0 to 13


@dataclass(frozen=True, eq=False)
class Quads:
    """What kernels read: see `nurbs/rpns/geometry.cl`. KSQuads go surface after surface, v fastest.

    Attributes:
        octets: (o, 8) uint32.
        firsts: (records,) uint32, the first control row of each span of all sides.
        beziers: (records, 64) float32.
        places: (quads, 2) uint32, the first vertex of each KSQuad and the columns of its grid.
        choose: (14, 14) float32, binomial coefficients.
    """

    octets: NDArray[np.uint32]
    firsts: NDArray[np.uint32]
    beziers: Floats
    places: NDArray[np.uint32]
    choose: Floats


def quads_of(model: NurbsModel, grids: Sequence[Grid], segments: int) -> Quads:
    """The tables of a model whose spans have so many segments."""
    octets: list[Numbers] = []
    firsts: list[Numbers] = []
    beziers: list[Doubles] = []
    places: list[Numbers] = []
    record = quad = 0
    for s, (surface, grid) in enumerate(zip(model.surfaces, grids, strict=True)):
        begins = [first_knots(knots) for knots in (surface.knots_u, surface.knots_v)]
        degrees = surface.degree_u, surface.degree_v
        rows, columns = (len(b) for b in begins)
        u, v = np.meshgrid(np.arange(rows), np.arange(0, columns, LINE), indexing="ij")
        u, v = u.ravel(), v.ravel()
        zero = np.zeros_like(u)
        octets.append(
            np.stack(
                [
                    zero + s, begins[0][u] - degrees[0], record + u, record + rows + v,
                    np.minimum(LINE, columns - v), quad + u * columns + v, zero, zero,
                ], axis=1,
            )
        )  # fmt: skip
        for knots, degree, begin in zip(
            (surface.knots_u, surface.knots_v), degrees, begins, strict=True
        ):
            firsts.append(begin - degree)
            beziers.append(_beziers(knots, degree, begin))
        i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
        vertex = grid.first + segments * (i * grid.columns + j)
        places.append(np.stack([vertex, np.full_like(vertex, grid.columns)], -1).reshape(-1, 2))
        record += rows + columns
        quad += rows * columns

    def joined(rows: list[Numbers] | list[Doubles], width: int) -> NDArray:
        return np.concatenate([np.zeros((0, width)), *rows])

    n = np.arange(DEGREES)
    return Quads(
        joined(octets, 8).astype(np.uint32),
        np.concatenate([np.zeros(0), *firsts]).astype(np.uint32),
        joined(beziers, 64).astype(np.float32),
        joined(places, 2).astype(np.uint32),
        np.asarray(comb(n[:, None], n[None]), np.float32),
    )


def _beziers(knots: Doubles, degree: int, begins: Numbers) -> Doubles:
    """For each span the matrix from its control points to those of the Bezier curve that it is, (spans, 64)."""
    t = np.arange(degree + 1) / degree
    spans = len(begins)
    samples = Samples(np.repeat(np.arange(spans), degree + 1), np.tile(t, spans))
    values = basis(knots, degree, samples)[0].reshape(spans, degree + 1, -1)
    local = begins[:, None] - degree + np.arange(degree + 1)
    values = np.take_along_axis(values, local[:, None], axis=2)
    i = np.arange(degree + 1)
    bernstein = comb(degree, i) * t[:, None] ** i * (1 - t[:, None]) ** (degree - i)
    found = np.zeros((spans, 8, 8))
    found[:, : degree + 1, : degree + 1] = np.linalg.solve(bernstein, values)
    return found.reshape(spans, 64)
