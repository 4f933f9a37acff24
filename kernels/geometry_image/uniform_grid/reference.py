"""A geometry image sampled on any even grid, its seam duplicates welded: numpy, float64."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import GeometryImage, TriangleMesh


def fold(cells: int) -> NDArray[np.int64]:
    """For each vertex of the grid, row by row, the one that stands for it: (cells + 1, cells + 1)."""
    row, column = np.indices((cells + 1, cells + 1))
    edge_row, edge_column = row % cells == 0, column % cells == 0
    folded_row = np.where(edge_column, np.minimum(row, cells - row), row)
    folded_column = np.where(edge_row, np.minimum(column, cells - column), column)
    return np.where(edge_row & edge_column, 0, folded_row * (cells + 1) + folded_column)


def sampled(image: NDArray[np.float32], cells: int) -> NDArray[np.float64]:
    """The image's samples, interpolated along rows and columns where the grid falls between them."""
    last = len(image) - 1
    at = np.arange(cells + 1) * last / cells
    low = np.minimum(at.astype(np.int64), last - 1)
    part = (at - low)[:, None]
    values = image.astype(np.float64)
    rows = values[low] * (1 - part[..., None]) + values[low + 1] * part[..., None]
    return rows[:, low] * (1 - part) + rows[:, low + 1] * part


def grid(image: GeometryImage, cells: int) -> TriangleMesh:
    """Two triangles per cell, their diagonals along the octahedron's edges; positions and unit normals."""
    own = fold(cells)
    p, q, r, s = own[:-1, :-1], own[:-1, 1:], own[1:, 1:], own[1:, :-1]
    right = 2 * np.arange(cells) >= cells
    anti = (right[:, None] == right[None, :])[..., None]
    one = np.where(anti, np.stack([p, q, s], -1), np.stack([p, q, r], -1))
    two = np.where(anti, np.stack([q, r, s], -1), np.stack([p, r, s], -1))
    used, faces = np.unique(np.stack([one, two], axis=2), return_inverse=True)
    positions = sampled(image.positions, cells).reshape(-1, 3)[used]
    normals = sampled(image.normals, cells).reshape(-1, 3)[used]
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    unit = np.where(length > 0, normals / np.where(length > 0, length, 1), (0.0, 0.0, 1.0))
    return TriangleMesh(positions.astype(np.float32), faces.reshape(-1, 3), unit)
