"""What the vertex stage of refinement should give, in float64 and in the papers' notation."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lodbench.datasets_gen.surfaces import Floats
from lodbench.kernels.refine.displacement import Doubles, Height, Wave

STILL = Wave()
Made = tuple[Doubles, Doubles, Doubles]
"""Points and unit normals (m, n, 3), and the length (m, n) that the normal had before it was made a unit."""
Reference = Callable[[Doubles, Doubles, Doubles], tuple[Doubles, Doubles]]
"""A surface: corners (m, 3, 3), their normals (m, 3, 3) and weights (n, 3) give points and normals, (m, n, 3) each."""


def refined(
    surface: Reference, P: Doubles, N: Doubles, wuv: Doubles, height: Height = STILL
) -> Made:
    """Points and normals of refined triangles.

    Args:
        surface: what is evaluated.
        P: corners, (m, 3 corners, 3) in model units.
        N: their normals, (m, 3 corners, 3), unit length.
        wuv: (n, 3) weights.
        height: displacement.

    Returns:
        Points and unit normals (m, n, 3), and the length (m, n) that the normal had before it was made a unit: where
        that is small, rounding has turned the normal by as much more. Points at a jump of the height are NaN.

    Source: Boubekeur & Schlick 2005, sections 3.2 and 4. The displaced surface's normal is a reconstruction.
    """
    points, directions = surface(P, N, wuv)
    normals, length = unit(directions)
    if height.a:
        raised, gradient, certain = height(points, normals, wuv)
        points = points + raised[..., None] * normals
        tangential = gradient - (gradient * normals).sum(-1, keepdims=True) * normals
        normals, bent = unit(normals - tangential)
        length = np.minimum(length, bent) * certain
    return points, normals, length


def unit(vectors: Doubles) -> tuple[Doubles, Doubles]:
    """Vectors at unit length, (0, 0, 1) where there is no direction, and the lengths they had."""
    length = np.linalg.norm(vectors, axis=-1)
    none = length <= 1e-15
    unit = vectors / np.where(none, 1, length)[..., None]
    return np.where(none[..., None], (0.0, 0.0, 1.0), unit), length


def largest_error(
    positions: Floats,
    normals: Floats,
    P: Doubles,
    N: Doubles,
    height: Height,
    surface: Reference,
    wuv: Doubles,
    then: Callable[[Made], Made] = lambda made: made,
) -> float:
    """How far refined triangles are from the reference, in units that float32 rounding keeps near 1e-7.

    Points count relative to the largest coordinate, normals as they are; both less where the mathematics magnifies
    rounding: a steep height does, far from the origin, and a normal that nearly cancelled. At a jump none counts.

    Args:
        positions: (m, n, 3).
        normals: likewise.
        P: corners, (m, 3 corners, 3).
        N: their normals.
        height: displacement.
        surface: what was to be evaluated.
        wuv: (n, 3) weights.
        then: what was done to the refined triangles.
    """
    points, directions, length = then(refined(surface, P, N, wuv, height))
    size = max(float(np.abs(P).max()), abs(height.a), 1e-37)
    slope = height.slope
    away = np.where(np.isnan(points), 0, np.abs(positions - points))
    off = away.max() / (size * (1 + slope))
    turned = (np.linalg.norm(normals - directions, axis=-1) * length).max()
    return float(np.max([off, turned / (1 + slope * (1 + height.bend * size))]))
