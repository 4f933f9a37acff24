"""NURBS surfaces in float64 and in the thesis's notation: the oracle of all systems of the family."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.nurbs_surface import Doubles, NurbsSurface
from lodbench.datasets_gen.surfaces import Floats
from lodbench.kernels.nurbs.samples import Samples, first_knots

DEGENERATE = 1e-11
"""Of the squared length of S_u x S_v over a KSQuad of size near 1, by parameters from 0 to 1 there: below, there is no
normal."""
CERTAIN = 1e-9
"""Likewise: below, control points rounded to float32 do not fix the normal to a tenth of a degree."""
INWARDS = 2.0**-10
"""How far towards the KSQuad's middle the normal is taken where it has none, as a share of the way."""


def cox_de_boor(knots: Doubles, i: int, degree: int, x: float) -> float:
    """N_{i,p}(x) by the recursion, 0 / 0 being 0: what the stair strategy does without.

    Source: Concheiro 2013, section 1.2; Piegl & Tiller, The NURBS Book, 1997, equation 2.5.
    """
    if degree == 0:
        last = x == knots[-1] and knots[i] < knots[i + 1] == x  # the end belongs to the last span
        return float(knots[i] <= x < knots[i + 1] or last)
    total = 0.0
    if (width := knots[i + degree] - knots[i]) > 0:
        total += (x - knots[i]) / width * cox_de_boor(knots, i, degree - 1, x)
    if (width := knots[i + degree + 1] - knots[i + 1]) > 0:
        total += (knots[i + degree + 1] - x) / width * cox_de_boor(knots, i + 1, degree - 1, x)
    return total


def stair(knots: Doubles, span: int, degree: int, x: float) -> Doubles:
    """N_{i-p,p}(x) ... N_{i,p}(x) on the span i that begins at knot `span`, (p + 1,): sums of products, no recursion.

    A path climbs from N_{i,0} = 1 to degree p; at each degree it keeps its index or steps down to the one before.
    N_{i-k,p} is the sum over all paths with k steps down. Every denominator spans x's own span and is never zero.

    Source: Concheiro 2013, section 6.5, whose formulas were not at hand: a reconstruction.
    """
    values = np.zeros(degree + 1)
    for k in range(degree + 1):
        for downs in combinations(range(1, degree + 1), k):
            product, r = 1.0, 0
            for d in range(1, degree + 1):
                low, high = knots[span - r], knots[span - r + d]
                if d in downs:
                    product *= (high - x) / (high - low)
                    r += 1
                else:
                    product *= (x - low) / (high - low)
            values[degree - k] += product
    return values


def basis(knots: Doubles, degree: int, samples: Samples) -> tuple[Doubles, Doubles]:
    """All basis functions at the samples, (n, controls), and the weights of control differences that make the slope,
    (n, controls - 1), by a parameter that runs from 0 to 1 over each span; by the triangular table.

    Source: Piegl & Tiller 1997, algorithms A2.2 and A2.3.
    """
    spans = first_knots(knots)[samples.spans]
    width = knots[spans + 1] - knots[spans]
    x = knots[spans] + samples.t * width
    rows = np.ones((len(x), 1))
    for d in range(1, degree + 1):
        r = np.arange(d)
        low, high = knots[spans[:, None] - r], knots[spans[:, None] - r + d]
        if d == degree:
            slopes = degree * rows * width[:, None] / (high - low)
        made = np.zeros((len(x), d + 1))  # by steps down
        made[:, :-1] += (x[:, None] - low) / (high - low) * rows
        made[:, 1:] += (high - x[:, None]) / (high - low) * rows
        rows = made
    count = len(knots) - degree - 1
    values, weights = np.zeros((len(x), count)), np.zeros((len(x), count - 1))
    at = np.arange(len(x))[:, None]
    values[at, spans[:, None] - np.arange(degree + 1)] = rows
    weights[at, spans[:, None] - 1 - np.arange(degree)] = slopes
    return values, weights


def surface_origin(surface: NurbsSurface) -> Floats:
    """The control point in its middle, (3,) float32: what kernels count its others from, to lose fewer bits."""
    rows, columns = surface.points.shape[:2]
    return surface.points[rows // 2, columns // 2].astype(np.float32)


def homogeneous(surface: NurbsSurface) -> Doubles:
    """Control points (w x, w y, w z, w) from the surface's origin, (n_u, n_v, 4); the largest weight is 1."""
    weights = (surface.weights / surface.weights.max())[..., None]
    return np.concatenate([(surface.points - surface_origin(surface)) * weights, weights], axis=2)


def quad_scales(surface: NurbsSurface) -> Floats:
    """The power of two that brings each KSQuad's control net near size 1, (spans_u, spans_v) float32."""
    spans = [first_knots(knots) for knots in (surface.knots_u, surface.knots_v)]
    net, size = surface.points, np.zeros((len(spans[0]), len(spans[1])))
    rows = [
        s[:, None] - np.arange(p + 1)
        for s, p in zip(spans, (surface.degree_u, surface.degree_v), strict=True)
    ]
    for axis in range(3):
        along = net[rows[0], :, axis]  # (spans_u, p + 1, n_v)
        low, high = along.min(1)[:, rows[1]].min(2), along.max(1)[:, rows[1]].max(2)
        size = np.maximum(size, high - low)
    exponents = np.frexp(np.where(size > 0, size, 1))[1]
    return np.ldexp(np.float32(1), np.clip(-exponents, -100, 100)).astype(np.float32)


def points_at(surface: NurbsSurface, u: Samples, v: Samples) -> Doubles:
    """Points on the grid of samples along u and v, (n_u, n_v, 3).

    Source: Concheiro 2013, section 6.2: S(u, v) = sum w_ij P_ij N_i,p N_j,q / sum w_ij N_i,p N_j,q.
    """
    along_u, along_v = _bases(surface, u, v)
    sums = np.einsum("ai,bj,ijk->abk", along_u[0], along_v[0], homogeneous(surface), optimize=True)
    return surface_origin(surface) + sums[..., :3] / sums[..., 3:]


def _bases(surface: NurbsSurface, u: Samples, v: Samples) -> list[tuple[Doubles, Doubles]]:
    return [
        basis(surface.knots_u, surface.degree_u, u),
        basis(surface.knots_v, surface.degree_v, v),
    ]


def _crossed(surface: NurbsSurface, u: Samples, v: Samples) -> Doubles:
    """S_u x S_v but for a positive factor, of KSQuads of size near 1, by parameters from 0 to 1 over each."""
    (nu, su), (nv, sv) = _bases(surface, u, v)
    net = homogeneous(surface)
    sums = np.einsum("ai,bj,ijk->abk", nu, nv, net, optimize=True)
    along_u = np.einsum("ai,bj,ijk->abk", su, nv, np.diff(net, axis=0), optimize=True)
    along_v = np.einsum("ai,bj,ijk->abk", nu, sv, np.diff(net, axis=1), optimize=True)
    scale = quad_scales(surface)[np.ix_(u.spans, v.spans)].astype(np.float64)[..., None]
    w = sums[..., 3:]
    S = sums[..., :3] / w
    along_u = (along_u[..., :3] - along_u[..., 3:] * S) * scale / w
    along_v = (along_v[..., :3] - along_v[..., 3:] * S) * scale / w
    return np.cross(along_u, along_v)


def normals_at(surface: NurbsSurface, u: Samples, v: Samples) -> tuple[Doubles, NDArray[np.bool_]]:
    """Unit normals on the grid of samples, (n_u, n_v, 3), and where float32 can tell them, (n_u, n_v).

    Where S_u x S_v vanishes, as at a collapsed edge, the normal is that of a place a little nearer to the KSQuad's
    middle; where there is none either, (0, 0, 1).

    Source: Concheiro 2013, section 1.2; what is done at degenerate places is a reconstruction.
    """
    normals = _crossed(surface, u, v)
    square = (normals**2).sum(-1)
    own = square > DEGENERATE
    if not own.all():
        inner = _crossed(surface, *(Samples(s.spans, s.t + INWARDS * (0.5 - s.t)) for s in (u, v)))
        normals = np.where(own[..., None], normals, inner)
    length = np.linalg.norm(normals, axis=-1, keepdims=True)
    unit = normals / np.where(length > 1e-15, length, 1)
    return np.where(length > 1e-15, unit, (0.0, 0.0, 1.0)), square > CERTAIN
