"""Which triangle of the sphere lies under each sample of the image."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.geometry_image.parameterisation import octahedron
from lodbench.kernels.geometry_image.parameterisation.hierarchy import Faces, Points

STEPS = 100_000
FIRST = 1  # the coarsest image, whose samples walk from anywhere


def neighbours(faces: Faces) -> Faces:
    """The triangle across each triangle's edges 0-1, 1-2, 2-0: (m, 3)."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    span = int(faces.max()) + 1
    order = np.argsort(start * span + end)
    other = order[np.searchsorted((start * span + end)[order], end * span + start)]
    return (other // 3).reshape(-1, 3)


class Locator:
    """Finds directions in a one-to-one triangulation of the sphere by walking over its triangles."""

    def __init__(self, sphere: Points, faces: Faces) -> None:
        self._corners = sphere[faces]  # (m, 3, 3)
        self._next = neighbours(faces)

    def walk(
        self, directions: Points, faces: NDArray[np.int64], rotation: Points, seed: int = 0
    ) -> tuple[NDArray[np.int64], Points]:
        """The triangle that holds each direction, and its barycentric coordinates there.

        Args:
            directions: (k, 3) float64, unit length, in the rotated frame.
            faces: (k,) where to start.
            rotation: (3, 3), sphere to rotated frame.
            seed: of the choice among edges; a fixed choice can go round in circles on such a mesh.

        Raises:
            RuntimeError: the walk does not end, which a one-to-one triangulation rules out.

        Source: Devillers, Pion & Teillaud 2002 (visibility walk, stochastic).
        """
        directions = directions @ rotation  # back into the sphere's own frame
        rng = np.random.default_rng(seed)
        found = faces.copy()
        weights = np.empty((len(directions), 3))
        todo = np.arange(len(directions))
        for _ in range(STEPS):
            here = found[todo]
            side = self._sides(directions[todo], here)
            outside = side < 0
            done = ~outside.any(axis=1)
            weights[todo[done]] = side[done]
            todo, outside, here = todo[~done], outside[~done], here[~done]
            if not len(todo):
                break
            choice = np.argmax(np.where(outside, rng.random(outside.shape), -1.0), axis=1)
            found[todo] = self._next[here, choice]
        else:
            raise RuntimeError("the walk over the sphere's triangles does not end")
        # side k belongs to edge k, k + 1, which faces corner k + 2
        weights = weights[:, [1, 2, 0]]
        return found, weights / weights.sum(axis=1, keepdims=True)

    def _sides(self, directions: Points, faces: NDArray[np.int64]) -> Points:
        """On which side of each edge: r . ((a - r) x (b - r)), exactly opposite for the triangle across it."""
        x, y, z = (
            [self._corners[faces, k, axis] - directions[:, axis] for k in range(3)]
            for axis in range(3)
        )
        side = np.empty((len(directions), 3))
        for k in range(3):
            j = (k + 1) % 3
            side[:, k] = (
                directions[:, 0] * (y[k] * z[j] - z[k] * y[j])
                + directions[:, 1] * (z[k] * x[j] - x[k] * z[j])
                + directions[:, 2] * (x[k] * y[j] - y[k] * x[j])
            )
        return side

    def image(self, n: int, rotation: Points) -> tuple[NDArray[np.int64], Points]:
        """Triangle (side, side) and barycentrics (side, side, 3) under each sample; seam duplicates are equal.

        Coarse samples are found first; each finer one starts from the triangle of a neighbour.
        """
        side = (1 << n) + 1
        faces = np.zeros((side, side), np.int64)
        weights = np.zeros((side, side, 3))
        directions = octahedron.sample_directions(n)
        own = octahedron.canonical(n) == np.arange(side * side).reshape(side, side)
        first = min(FIRST, n)
        for level in range(first, n + 1):
            step = 1 << (n - level)
            row, column = np.meshgrid(
                np.arange(0, side, step), np.arange(0, side, step), indexing="ij"
            )
            new = (row // step % 2 + column // step % 2 > 0) | (level == first)
            row, column = row[new], column[new]
            start = faces[row - row % (2 * step), column - column % (2 * step)]
            keep = own[row, column]
            row, column, start = row[keep], column[keep], start[keep]
            faces[row, column], weights[row, column] = self.walk(
                directions[row, column], start, rotation
            )
            _copy_seam(faces, weights, level, n)
        return faces, weights


def _copy_seam(faces: NDArray[np.int64], weights: Points, level: int, n: int) -> None:
    """Give the border samples of `level` what the samples that stand for them have."""
    step = 1 << (n - level)
    own = octahedron.canonical(level)
    row, column = own // ((1 << level) + 1) * step, own % ((1 << level) + 1) * step
    faces[::step, ::step] = faces[row, column]
    weights[::step, ::step] = weights[row, column]
