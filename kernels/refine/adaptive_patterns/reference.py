"""Adaptive patterns in numpy, for reading: which pattern a triangle takes, and where geomorphing puts its vertices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Floats, Indices
from lodbench.kernels.refine.adaptive_patterns.pool import Pattern, number
from lodbench.kernels.refine.reference import Made, unit


def edge_depths(triangles: Indices, tags: Floats, finest: int) -> tuple[NDArray[np.int64], Floats]:
    """Depths of the edges P1 P2, P2 P0 and P0 P1 of each triangle, (m, 3), and how far each edge's last level and the
    triangle's have come, (m, 4) float32 above 0 and up to 1.

    Args:
        triangles: (m, 3).
        tags: (n,) float32, 0 to finest.
        finest: the largest depth.

    Source: GPU Gems 3, chapter 5: an edge's depth is the mean of its ends' tags; rounding up is a reconstruction.
    """
    a, b, c = tags[triangles].astype(np.float32).T
    mean = np.stack([b + c, c + a, a + b], axis=1) * np.float32(0.5)
    depths = np.minimum(np.ceil(mean).astype(np.int64), finest)
    every = np.column_stack([mean, mean.max(axis=1)])
    levels = np.column_stack([depths, depths.max(axis=1)])
    blends = np.where(levels > 0, every - (levels - 1).astype(np.float32), np.float32(1))
    return depths, blends.astype(np.float32)


def pattern_numbers(depths: NDArray[np.int64], finest: int) -> NDArray[np.uint32]:
    """The pattern of each triangle, (m,), by its place in the pool."""
    return np.array([number((i, j, k), finest) for i, j, k in depths.tolist()], np.uint32)


def morphed(pattern: Pattern, made: Made, blends: Floats) -> Made:
    """What geomorphing makes of refined triangles.

    Args:
        pattern: of n vertices.
        made: points and unit normals (m, n, 3), and the normals' lengths (m, n).
        blends: (m, 4), of each triangle's edges and inside.

    Source: Boubekeur & Schlick 2005, section 6, names it as future work: a reconstruction.
    """
    points, normals, length = (values.copy() for values in made)
    for own, one, other, kind in pattern.moves.tolist():
        blend = blends[:, kind, None].astype(np.float64)
        for values in (points, normals):
            middle = (values[:, one] + values[:, other]) / 2
            values[:, own] = middle + (values[:, own] - middle) * blend
        normals[:, own], bent = unit(normals[:, own])
        length[:, own] = np.minimum(bent, length[:, [own, one, other]].min(axis=1))
    return points, normals, length
