"""Any surface as triangles fine enough to look at, and to measure others against: float64 on the host."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline
from scipy.special import comb

from lodbench.datasets_gen.nurbs_surface import NurbsSurface
from lodbench.datasets_gen.surfaces import BezierPatches, GeometryImage, Surface, TriangleMesh

SEGMENTS = 32  # of a Bezier patch's side, and of a knot span
MOST = 2000  # of a NURBS surface's side


@lru_cache(maxsize=4)
def finest(surface: Surface) -> TriangleMesh:
    """The surface as a triangle mesh about its origin; a mesh is itself.

    Bezier patches get 32 segments a side, NURBS surfaces 32 per knot span and at most 2,000 a side, a geometry image
    all its samples. Sides are not joined to their neighbours: topology is not to be read off it.
    """
    if isinstance(surface, TriangleMesh):
        return surface
    if isinstance(surface, GeometryImage):
        return _meshed([surface.positions], surface.origin)
    if isinstance(surface, BezierPatches):
        return _meshed(_bezier(surface.points.astype(np.float64)))
    return _meshed([_nurbs(one) for one in surface.surfaces])


def _bezier(points: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """(n, 4, 4, 3) to a grid of points each."""
    t, i = np.linspace(0, 1, SEGMENTS + 1)[:, None], np.arange(4)
    basis = comb(3, i) * t**i * (1 - t) ** (3 - i)
    return list(np.einsum("ui,vj,nijk->nuvk", basis, basis, points))


def _nurbs(surface: NurbsSurface) -> NDArray[np.float64]:
    """A grid of points: weighted sums over the control points, over the sums of their weights."""
    bases = []
    for degree, knots in ((surface.degree_u, surface.knots_u), (surface.degree_v, surface.knots_v)):
        low, high = knots[degree], knots[-degree - 1]
        spans = len(np.unique(knots[(knots >= low) & (knots <= high)])) - 1
        at = np.linspace(low, high, min(SEGMENTS * max(spans, 1), MOST) + 1)
        bases.append(BSpline(knots, np.eye(len(knots) - degree - 1), degree)(at))
    weighted = np.concatenate(
        [surface.points * surface.weights[..., None], surface.weights[..., None]], axis=2
    )
    sums = np.einsum("ui,vj,ijk->uvk", *bases, weighted, optimize=True)
    return sums[..., :3] / sums[..., 3:]


def _meshed(grids: list[NDArray], origin: NDArray[np.float64] | None = None) -> TriangleMesh:
    """Grids of points, (rows, columns, 3), as one mesh: two triangles a cell."""
    faces, first = [], 0
    for grid in grids:
        rows, columns = grid.shape[:2]
        own = first + np.arange(rows * columns).reshape(rows, columns)
        a, b, c, d = own[:-1, :-1], own[:-1, 1:], own[1:, 1:], own[1:, :-1]
        faces += [np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)]
        first += rows * columns
    points = [np.asarray(grid, np.float32).reshape(-1, 3) for grid in grids]
    return TriangleMesh(
        np.concatenate([np.zeros((0, 3), np.float32), *points]),
        np.concatenate([np.zeros((0, 3), np.uint32), *faces]),
        origin=origin,
    )
