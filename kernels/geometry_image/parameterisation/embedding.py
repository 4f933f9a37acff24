"""The default spherical parameterisation: put a tetrahedron on the sphere and undo the collapses, coarse to fine."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lodbench.kernels.geometry_image.parameterisation import stars
from lodbench.kernels.geometry_image.parameterisation.hierarchy import (
    Faces,
    Level,
    Points,
    take_apart,
)

SWEEPS = 12  # after each level; half as many leave 4 % more error, twice as many gain nothing
SHRINK = 0.7
TRIALS = 60
COARSE_TRIALS = 3  # every third trial is enough for nearly all

Sweep = Callable[[Points, stars.Stars, int, int], None]
Progress = Callable[[float], None]


def _unit(vectors: Points) -> Points:
    with np.errstate(invalid="ignore", divide="ignore"):
        return vectors / np.sqrt(np.einsum("...i,...i->...", vectors, vectors))[..., None]


def base_tetrahedron(sphere: Points, faces: Faces) -> None:
    """The four vertices left on a regular tetrahedron, outside out."""
    corners = np.unique(faces)
    sphere[corners] = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(3)
    a, b, c = sphere[faces[0]]
    if np.dot(a, np.cross(b - a, c - a)) < 0:
        sphere[corners[:2]] = sphere[corners[1::-1]]


def insert(sphere: Points, level: Level) -> None:
    """The level's vertices inside the kernels of their rings, as far from all ring edges as the trials find.

    The ring is star-shaped around its first vertex v, so the wedge between v's two ring edges holds kernel points
    arbitrarily near to v.

    Raises:
        RuntimeError: no trial lies inside; rounding has eaten the kernel.

    Source: Praun & Hoppe 2003, section 4.2; the trials are a reconstruction.
    """
    for d in np.unique(level.valence):
        rows = np.flatnonzero(level.valence == d)
        ring = sphere[level.rings[rows, :d]]
        best, margin = _best_inside(ring, np.arange(0, TRIALS, COARSE_TRIALS))
        poor = np.flatnonzero(~(margin > 0))
        if len(poor):
            best[poor], margin[poor] = _best_inside(ring[poor], np.arange(TRIALS))
        if not (margin > 0).all():
            raise RuntimeError("the coarse-to-fine embedding found no place for a vertex")
        sphere[level.removed[rows]] = best


def _best_inside(ring: Points, exponents: np.ndarray) -> tuple[Points, np.ndarray]:
    v = ring[:, 0]
    edge_normals = _unit(np.cross(ring, np.roll(ring, -1, axis=1)))
    inward = _unit(edge_normals[:, 0] + edge_normals[:, -1])
    reach = np.sqrt(((ring - v[:, None]) ** 2).sum(-1).max(axis=1))
    middle = _unit(ring.sum(axis=1))
    t = (SHRINK**exponents)[None, :, None]
    along = v[:, None] + t * (reach[:, None] * inward)[:, None]
    between = (1 - t) * v[:, None] + t * middle[:, None]
    trial = _unit(np.concatenate([along, between], axis=1))
    margins = np.matmul(trial, edge_normals.transpose(0, 2, 1)).min(axis=2)
    margins = np.where(np.isnan(margins), -np.inf, margins)
    best = np.argmax(margins, axis=1)
    row = np.arange(len(ring))
    return trial[row, best], margins[row, best]


def coarse_to_fine(
    positions: Points,
    faces: Faces,
    seed: int = 0,
    sweep: Sweep = stars.sweep,
    progress: Progress | None = None,
) -> Points:
    """A point of the unit sphere for each vertex, no triangle turned over: (n, 3) float64.

    Args:
        positions: (n, 3) float64, total area about 4 pi.
        faces: (m, 3) int64, closed, oriented, genus 0.
        seed: of the order of collapses and of the colourings.
        sweep: what moves all vertices; the host's, or a `DeviceSweep`.
        progress: called with the share done, 0 to 1.

    Source: Praun & Hoppe 2003, section 4 (coarse-to-fine, stretch optimised after each batch).
    """
    report = progress or (lambda share: None)
    levels, base = take_apart(positions, faces, seed, lambda share: report(0.25 * share))
    sphere = np.zeros_like(positions)
    base_tetrahedron(sphere, base)
    sizes = np.array([len(level.faces) // 2 + 2 for level in levels])
    work, done, turn = sizes.sum(), 0, 0
    for k in reversed(range(len(levels))):
        level, size = levels[k], sizes[k]
        insert(sphere, level)
        moved = stars.Stars.of(positions, level.faces, np.unique(level.faces), seed + k)
        sweep(sphere, moved, turn, SWEEPS)
        turn += SWEEPS
        done += size
        report(0.25 + 0.75 * done / work)
    return sphere
