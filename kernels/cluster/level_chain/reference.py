"""A chain of levels in float64, written for reading: each level clusters the mesh itself, on a halved grid."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.cluster.level_chain.params import Params
from lodbench.kernels.cluster.quadric_clustering.reference import Reference, on_grid


def halved(grid: Grid) -> Grid:
    """The grid of cells twice as long, from the same corner; the last cell along an axis may stick out of the box.

    All factors are powers of two, so a position's cell is that of the finer grid, halved, whatever rounding did.
    """
    x, y, z = (-(-count // 2) for count in grid.counts)
    return replace(
        grid,
        counts=(x, y, z),
        inverse=np.float32(grid.inverse / 2),
        unit=np.float32(grid.unit * 2),
        extent=grid.extent / 2,
    )


def simplify(mesh: TriangleMesh, params: Params) -> list[Reference]:
    """Every level, finest first; that sums of sums are the sums of all is what the chain has to show.

    Source: DeCoro & Tatarchuk 2007, slides 12, 15 and 17.
    """
    grid = Grid.over(*mesh.box, params.grid_cells)
    levels = []
    for _ in range(params.levels):
        levels.append(on_grid(mesh, grid, params))
        grid = halved(grid)
    return levels
