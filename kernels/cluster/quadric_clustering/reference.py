"""Quadric vertex clustering in float64, written for reading; only the cell of a vertex is decided in float32."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.borders import (
    NO_EDGES,
    NO_VERTICES,
    border_vertices,
    edges_of,
    used_once,
)
from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.cluster.quadric_clustering.params import HEAVINESS, Params
from lodbench.kernels.cluster.warp import Warp

NO_VERTEX = np.uint32(0xFFFFFFFF)
KINDS = ("mean", "solved", "solved_1e-2", "solved_1e-1")


@dataclass(frozen=True)
class Reference:
    """A simplified mesh with what led to it; one row per output vertex where the shape says n.

    Attributes:
        mesh: positions (n, 3), triangles in input order.
        grid: the even grid, whose units lengths are in.
        points: representatives in units of the largest cell edge, (n, 3) float64.
        means: means of the corners in each cell, in the same units, (n, 3) float64.
        A: summed quadrics' matrices, (n, 3, 3) float64.
        b: their vectors, relative to `means`, (n, 3) float64.
        kinds: index into KINDS of how each was placed, (n,).
        margins: how far each was from being placed otherwise, as a share of the limit that decided, (n,).
        limits: the longest steps of each along x, y, z, (n, 3) float64; 1 without a warp.
        vertex_map: output vertex of each input vertex, 0xFFFFFFFF where none, uint32.
    """

    mesh: TriangleMesh
    grid: Grid
    points: NDArray[np.float64]
    means: NDArray[np.float64]
    A: NDArray[np.float64]
    b: NDArray[np.float64]
    kinds: NDArray[np.int64]
    margins: NDArray[np.float64]
    limits: NDArray[np.float64]
    vertex_map: NDArray[np.uint32]


def simplify(mesh: TriangleMesh, params: Params, warp: Warp | None = None) -> Reference:
    """The mesh with one vertex per used cell of the grid that `params` names; a target is for the search to meet.

    Cells are even where the `warp` has the vertices; all else is in the mesh's own space.

    Source: DeCoro & Tatarchuk 2007, slides 12, 15 and 17; Lindstrom 2000 for the solve around the mean.
    """
    if warp is None:
        return on_grid(mesh, Grid.over(*mesh.box, params.grid_cells), params)
    cells, limit = warp.cells(mesh.positions, params.grid_cells)
    return _simplified(mesh, warp.even(params.grid_cells), cells, limit, params)


def on_grid(mesh: TriangleMesh, grid: Grid, params: Params) -> Reference:
    """The same on any grid of even cells."""
    cells = grid.cells_of(grid.points(mesh.positions))
    return _simplified(mesh, grid, cells, np.ones((mesh.vertex_count, 3)), params)


def _simplified(
    mesh: TriangleMesh,
    grid: Grid,
    cells: NDArray[np.int64],
    limit: NDArray[np.float64],
    params: Params,
) -> Reference:
    """The same of vertices in these cells; `limit` is how far each lets its cell's representative step."""
    points = grid.points(mesh.positions).astype(np.float64)
    border = used_once(edges_of(mesh.triangles), mesh.positions) if params.uses_border else NO_EDGES
    kept = border_vertices(border) if params.keeps_border else NO_VERTICES
    own_cells = int(cells.max(initial=0)) + 1
    cells[kept] = own_cells + np.arange(len(kept))

    # pass 3: a triangle survives when its corners lie in three cells; its cells are used
    corners = cells[mesh.triangles].reshape(-1, 3)
    a, b, c = corners.T
    survivors = corners[(a != b) & (b != c) & (c != a)]
    used, triangles = np.unique(survivors, return_inverse=True)
    triangles = triangles.reshape(-1, 3)

    # pass 1: area/3 [n; d][n; d]^T and the corner's position go to the cell of each corner
    A, b_sum, position_sum, count = accumulate(points, mesh.triangles, corners, used)
    if params.holds_border:
        hold(A, b_sum, points, border, cells, used)

    # pass 2
    means = position_sum / np.maximum(count, 1)[:, None]
    b_mean = np.einsum("nij,nj->ni", A, means) + b_sum
    row = np.searchsorted(used, cells)
    row[row == len(used)] = 0
    found = used[row] == cells if len(used) else np.zeros(len(cells), bool)
    limits = np.zeros((len(used), 3))
    np.maximum.at(limits, row[found], limit[found])
    per_box = 1 / grid.extent if grid.extent else 1.0
    steps, kinds, margins = place(A, b_mean, params.placement, per_box, limits)

    positions = grid.positions(means + steps)
    own = used >= own_cells
    positions[own] = mesh.positions[kept[used[own] - own_cells]]
    if params.remove_duplicates:
        keys = np.sort(triangles, axis=1)
        _, first = np.unique(keys, axis=0, return_index=True)
        triangles = triangles[np.sort(first)]
    return Reference(
        mesh=TriangleMesh(positions, triangles),
        grid=grid,
        points=means + steps,
        means=means,
        A=A,
        b=b_mean,
        kinds=kinds,
        margins=margins,
        limits=limits,
        vertex_map=np.where(found, row, NO_VERTEX).astype(np.uint32),
    )


def accumulate(
    points: NDArray[np.float64],
    triangles: NDArray[np.uint32],
    corners: NDArray[np.int64],
    used: NDArray[np.int64],
) -> tuple[NDArray, NDArray, NDArray, NDArray]:
    """Sums over the corners in each used cell: A (n, 3, 3), b (n, 3), positions (n, 3), corners (n,).

    Source: DeCoro & Tatarchuk 2007, slide 12. Two corners in a cell count twice.
    """
    p0, p1, p2 = (points[triangles[:, corner]] for corner in range(3))
    m = np.cross(p1 - p0, p2 - p0)
    length = np.linalg.norm(m, axis=1)
    # no area, no plane: such a triangle counts at its corners alone
    normal = m / np.where(length > 0, length, 1)[:, None]
    area = length / 6  # a third of the triangle's
    distance = -np.einsum("ni,ni->n", normal, p0)
    A_triangle = area[:, None, None] * normal[:, :, None] * normal[:, None, :]
    b_triangle = (area * distance)[:, None] * normal

    n = len(used)
    A, b, position = np.zeros((n, 3, 3)), np.zeros((n, 3)), np.zeros((n, 3))
    count = np.zeros(n)
    for corner in range(3):
        row = np.searchsorted(used, corners[:, corner])
        row[row == n] = 0
        inside = used[row] == corners[:, corner] if n else np.zeros(len(row), bool)
        row = row[inside]
        count += np.bincount(row, minlength=n)
        at = points[triangles[inside, corner]]
        for i in range(3):
            position[:, i] += np.bincount(row, at[:, i], n)
            b[:, i] += np.bincount(row, b_triangle[inside, i], n)
            for j in range(3):
                A[:, i, j] += np.bincount(row, A_triangle[inside, i, j], n)
    return A, b, position, count


def border_quadrics(
    points: NDArray[np.float64], border: NDArray[np.uint32]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """What each border edge adds to the A (k, 3, 3) and b (k, 3) of its ends' cells.

    Source: Lindstrom & Turk 1998: the plane through the edge, upright on its triangle, by the square of its length. Its
    weight beside the triangles' is a reconstruction.
    """
    a, b, c = (points[border[:, corner]] for corner in range(3))
    along, side = b - a, c - a
    square = (along**2).sum(axis=1)
    upright = side - along * ((side * along).sum(axis=1) / np.maximum(square, 1e-30))[:, None]
    height = np.linalg.norm(upright, axis=1)
    flat = ~((square > 1e-30) & (height**2 > 1e-12 * square))
    normal = upright / np.where(flat, 1, height)[:, None]
    weight = np.where(flat, 0, HEAVINESS * square)
    distance = -(normal * a).sum(axis=1)
    A = weight[:, None, None] * normal[:, :, None] * normal[:, None, :]
    return A, (weight * distance)[:, None] * normal


def hold(
    A: NDArray[np.float64],
    b: NDArray[np.float64],
    points: NDArray[np.float64],
    border: NDArray[np.uint32],
    cells: NDArray[np.int64],
    used: NDArray[np.int64],
) -> None:
    """Add to A (n, 3, 3) and b (n, 3) of the used cells the border edges with an end there, once for each end."""
    own_A, own_b = border_quadrics(points, border)
    for end in (0, 1):
        own = cells[border[:, end]]
        row = np.searchsorted(used, own)
        row[row == len(used)] = 0
        inside = used[row] == own if len(used) else np.zeros(len(row), bool)
        np.add.at(A, row[inside], own_A[inside])
        np.add.at(b, row[inside], own_b[inside])


def place(
    A: NDArray[np.float64],
    b: NDArray[np.float64],
    placement: str,
    per_box: float,
    limits: NDArray[np.float64] | None = None,
    ridges: tuple[float, ...] = (1e-3, 1e-2, 1e-1),
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float64]]:
    """Steps from the mean (n, 3), index into KINDS (n,) and margins (n,), for quadrics about the mean.

    `limits`: how far each may step along x, y and z, (n, 3); None: 1. `ridges`: of "robust", shares of the trace.

    Source: DeCoro & Tatarchuk 2007, slide 15 for "paper"; the cascade is a reconstruction.
    """
    limits = np.ones_like(b) if limits is None else np.maximum(limits, 1e-30)
    steps, kinds = np.zeros_like(b), np.zeros(len(b), np.int64)
    margins = np.full(len(b), np.inf)
    if placement == "paper":
        determinant = np.linalg.det(A * per_box**2)  # areas where the longest box edge is 1
        solvable = determinant > 1e-11
        steps[solvable] = -np.linalg.solve(A[solvable], b[solvable, :, None])[..., 0]
        kinds[solvable] = 1
        margins = np.abs(determinant / 1e-11 - 1)
    elif placement == "robust":
        trace = np.trace(A, axis1=1, axis2=2)
        open_ = trace > 1e-30
        for attempt, ridge in enumerate(ridges):
            rows = np.flatnonzero(open_)
            scale = trace[rows, None, None]
            step = -np.linalg.solve(A[rows] / scale + ridge * np.eye(3), b[rows, :, None] / scale)
            step = step[..., 0]
            length = np.linalg.norm(step / limits[rows], axis=1)
            margins[rows] = np.minimum(margins[rows], np.abs(length - 1))
            taken = length <= 1
            steps[rows[taken]] = step[taken]
            kinds[rows[taken]] = attempt + 1
            open_[rows[taken]] = False
    return steps, kinds, margins
