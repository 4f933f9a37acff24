"""Culling of KSQuads in float64: each technique as it is defined, and what really faces away."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.nurbs_surface import Doubles, NurbsModel, NurbsSurface
from lodbench.kernels.nurbs.reference import homogeneous, normals_at, points_at, surface_origin
from lodbench.kernels.nurbs.samples import Samples, first_knots
from lodbench.kernels.system import View

Flags = NDArray[np.bool_]


def facing(surface: NurbsSurface, view: View, samples: int = 8) -> Doubles:
    """The share of sample points of each KSQuad, its ends among them, that are in view and face the eye,
    (spans_u, spans_v).
    """
    t, sides = np.linspace(0, 1, samples + 1), []
    for knots in (surface.knots_u, surface.knots_v):
        spans = len(first_knots(knots))
        sides.append(Samples(np.repeat(np.arange(spans), samples + 1), np.tile(t, spans)))
    points, normals = points_at(surface, *sides), normals_at(surface, *sides)[0]
    seen = ((view.eye - points) * normals).sum(axis=2) > 0
    x, y, _, w = np.moveaxis(points @ view.world_to_clip[:, :3].T + view.world_to_clip[:, 3], -1, 0)
    seen &= (np.abs(x) <= w) & (np.abs(y) <= w)
    return seen.reshape(-1, samples + 1, seen.shape[1] // (samples + 1), samples + 1).mean((1, 3))


def beside(surface: NurbsSurface, view: View) -> Flags:
    """All control points beyond one side of the image, (spans_u, spans_v)."""
    X = homogeneous(surface)
    X = np.concatenate([X[..., :3] + X[..., 3:] * surface_origin(surface), X[..., 3:]], axis=2)
    x, y, _, w = np.moveaxis(X @ view.world_to_clip.T, -1, 0)
    rows = [
        first_knots(knots)[:, None] - degree + np.arange(degree + 1)
        for knots, degree in (
            (surface.knots_u, surface.degree_u),
            (surface.knots_v, surface.degree_v),
        )
    ]
    u, v = rows[0][:, None, :, None], rows[1][None, :, None, :]
    beyond = [side[u, v].all(axis=(2, 3)) for side in (x < -w, x > w, y < -w, y > w)]
    return np.any(beyond, axis=0)


def faces_away(surface: NurbsSurface, eye: Doubles, light: bool) -> Flags:
    """Strong or light quad culling: all chosen triangles of the control net face away, (spans_u, spans_v).

    Source: Concheiro 2013, section 6.4.2; which quads light culling looks at is a reconstruction: those in the middle
    of the net, or the four corners where the degree is below three.
    """
    X = surface.points - eye
    a, b, c, d = X[:-1, :-1], X[1:, :-1], X[1:, 1:], X[:-1, 1:]
    away = ((a * np.cross(b, c)).sum(2) >= 0) & ((a * np.cross(c, d)).sum(2) >= 0)
    chosen = []
    for knots, degree in ((surface.knots_u, surface.degree_u), (surface.knots_v, surface.degree_v)):
        steps = np.arange(degree)
        if light and degree >= 3:
            steps = np.unique([(degree - 1) // 2, degree // 2])
        elif light:
            steps = np.unique([0, degree - 1])
        chosen.append(first_knots(knots)[:, None] - degree + steps)
    i, j = chosen
    return away[i[:, None, :, None], j[None, :, None, :]].all(axis=(2, 3))


@lru_cache(maxsize=8)  # techniques are compared on one model in the same views
def visible(model: NurbsModel, view: View) -> Doubles:
    """`facing` of all KSQuads of a model, in their order; the array is lent."""
    found = np.concatenate([np.zeros(0), *(facing(s, view).ravel() for s in model.surfaces)])
    found.setflags(write=False)
    return found
