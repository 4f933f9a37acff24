"""A refined surface against the same refined further, at the same parameters: what a coarser pattern leaves out.

Patterns are nested where the segments of one divide those of the other: every vertex of the finer lies at a place of
the coarser that integers give, a corner of a triangle or within one, and nothing is searched for.

Source: Boubekeur & Schlick 2005, section 3.2 and figure 4, for what is compared; the measure is ours.
"""

from __future__ import annotations

from math import isqrt

import numpy as np

from lodbench.datasets_gen.surfaces import Floats, TriangleMesh
from lodbench.kernels.refine.lattice import lattice_interpolation, lattice_vertex_count


def _pattern(mesh: TriangleMesh, coarse: int) -> tuple[int, Floats]:
    """Segments of the pattern over `coarse` triangles, and the vertices of each, (coarse, n, 3).

    Raises:
        ValueError: the mesh is not made of the instances of one pattern.
    """
    segments = isqrt(mesh.triangle_count // coarse) if coarse else 0
    count = lattice_vertex_count(segments)
    if (
        not segments
        or mesh.triangle_count != coarse * segments**2
        or mesh.vertex_count != coarse * count
    ):
        raise ValueError(
            f"result: expected {coarse:,} instances of a pattern to compare, got {mesh.vertex_count:,} vertices "
            f"and {mesh.triangle_count:,} triangles"
        )
    return segments, mesh.positions.reshape(coarse, count, 3)


def difference(
    coarse: TriangleMesh, result: TriangleMesh, reference: TriangleMesh
) -> dict[str, float | int]:
    """How far a refined surface is from one refined further, at the parameters of all vertices of the latter.

    Args:
        coarse: what both are refinements of; distances are fractions of its bounding-box diagonal.
        result: instances of a pattern, coarse triangle after coarse triangle, its flat triangles in between.
        reference: the same with a multiple of the segments.

    Returns:
        `rms_difference`: root of the mean squared distance; every coarse triangle counts alike, whatever its area.
        `max_difference`: the largest. `compared_points`: vertices of the reference.

    Raises:
        ValueError: one of the two is no such mesh, or the patterns are not nested.
    """
    segments, points = _pattern(result, coarse.triangle_count)
    finer, wanted = _pattern(reference, coarse.triangle_count)
    if finer % segments:
        raise ValueError(f"segments: expected a divisor of {finer} to compare, got {segments}")
    vertices, weights = lattice_interpolation(segments, finer)
    total = largest = 0.0
    for own, theirs in zip(
        points, wanted, strict=True
    ):  # an instance at a time: the finest are large
        there = np.einsum("kn,knd->nd", weights, own.astype(np.float64)[vertices])
        square = ((there - theirs) ** 2).sum(axis=1)
        total += float(square.sum())
        largest = max(largest, float(square.max()))
    compared, diagonal = reference.vertex_count, coarse.diagonal or 1.0
    return {
        "rms_difference": float(np.sqrt(total / compared)) / diagonal,
        "max_difference": float(np.sqrt(largest)) / diagonal,
        "compared_points": compared,
    }
