"""Culling of KSQuads in float64: each technique as it is defined, and what really faces away."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.nurbs_surface import Doubles, NurbsModel, NurbsSurface
from lodbench.kernels.nurbs.reference import normals_at, points_at
from lodbench.kernels.nurbs.samples import Samples, first_knots

Flags = NDArray[np.bool_]


def facing(surface: NurbsSurface, eye: Doubles, samples: int = 8) -> Doubles:
    """The share of sample points of each KSQuad, its ends among them, that face the eye, (spans_u, spans_v)."""
    t, sides = np.linspace(0, 1, samples + 1), []
    for knots in (surface.knots_u, surface.knots_v):
        spans = len(first_knots(knots))
        sides.append(Samples(np.repeat(np.arange(spans), samples + 1), np.tile(t, spans)))
    points, normals = points_at(surface, *sides), normals_at(surface, *sides)[0]
    towards = ((eye - points) * normals).sum(axis=2) > 0
    return towards.reshape(-1, samples + 1, towards.shape[1] // (samples + 1), samples + 1).mean(
        (1, 3)
    )


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


def visible(model: NurbsModel, eye: Doubles) -> Doubles:
    """`facing` of all KSQuads of a model, in their order."""
    found = [facing(surface, eye).ravel() for surface in model.surfaces]
    return np.concatenate([np.zeros(0), *found])
