"""The sphere unfolded over an octahedron into a square, and which of the square's border samples are one point."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.geometry_image.parameterisation.hierarchy import Points


def _sign(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """1 or -1; 1 at zero, so that fold lines go one way."""
    return np.where(values < 0, -1.0, 1.0)


def to_square(directions: Points) -> Points:
    """Directions (..., 3), not zero, to the square -1..1: (..., 2). +z is its centre, -z all four corners.

    Source: Praun & Hoppe 2003, section 5 (octahedral domain, unfolded); Wang et al., section 2 ("linear" map).
    """
    on = directions / np.abs(directions).sum(axis=-1, keepdims=True)
    x, y = on[..., 0], on[..., 1]
    below = on[..., 2] < 0
    return np.stack(
        [
            np.where(below, (1 - np.abs(y)) * _sign(x), x),
            np.where(below, (1 - np.abs(x)) * _sign(y), y),
        ],
        axis=-1,
    )


def to_directions(square: Points) -> Points:
    """The inverse of `to_square`: unit directions (..., 3)."""
    x, y = square[..., 0], square[..., 1]
    z = 1 - np.abs(x) - np.abs(y)
    below = z < 0
    result = np.stack(
        [
            np.where(below, (1 - np.abs(y)) * _sign(x), x),
            np.where(below, (1 - np.abs(x)) * _sign(y), y),
            z,
        ],
        axis=-1,
    )
    return result / np.sqrt((result**2).sum(axis=-1, keepdims=True))


def sample_directions(n: int) -> Points:
    """Directions of all samples of the (2^n + 1)^2 image, row (y), column (x): (side, side, 3)."""
    ticks = np.linspace(-1.0, 1.0, (1 << n) + 1)
    return to_directions(np.stack(np.meshgrid(ticks, ticks), axis=-1))


def canonical(n: int) -> NDArray[np.int64]:
    """For each sample of the image, the row-major index of the sample that stands for the same point: (side, side).

    A border side folds about its middle, and the four corners are one point.
    """
    last = 1 << n
    row, column = np.indices((last + 1, last + 1))
    edge_row, edge_column = (row == 0) | (row == last), (column == 0) | (column == last)
    folded_column = np.where(edge_row, np.minimum(column, last - column), column)
    folded_row = np.where(edge_column, np.minimum(row, last - row), row)
    corner = edge_row & edge_column
    return np.where(corner, 0, folded_row * (last + 1) + folded_column)
