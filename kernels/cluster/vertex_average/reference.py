"""Vertex clustering with means in float64, written for reading; only the cell of a vertex is decided in float32."""

from __future__ import annotations

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.cluster.unchanged import without_duplicates
from lodbench.kernels.cluster.warp import Warp
from lodbench.kernels.cluster.warped import WarpedTarget


def simplify(mesh: TriangleMesh, params: WarpedTarget, warp: Warp | None = None) -> TriangleMesh:
    """The mesh with one vertex per used cell of the grid that `params` names, in the order of the cells."""
    if warp is None:
        grid = Grid.over(*mesh.box, params.grid_cells)
        cells = grid.cells_of(grid.points(mesh.positions))
    else:
        grid = warp.even(params.grid_cells)
        cells, _ = warp.cells(mesh.positions, params.grid_cells)
    points = grid.points(mesh.positions)
    corners = cells[mesh.triangles].reshape(-1, 3)
    a, b, c = corners.T
    used, triangles = np.unique(corners[(a != b) & (b != c) & (c != a)], return_inverse=True)
    row = np.searchsorted(used, cells)
    inside = np.flatnonzero(row < len(used))
    inside = inside[used[row[inside]] == cells[inside]]
    count = np.bincount(row[inside], minlength=len(used))
    sums = [np.bincount(row[inside], axis[inside], len(used)) for axis in points.T]
    means = np.stack(sums, axis=1) / np.maximum(count, 1)[:, None]
    made = TriangleMesh(grid.positions(means), triangles.reshape(-1, 3))
    return without_duplicates(made) if params.remove_duplicates else made
