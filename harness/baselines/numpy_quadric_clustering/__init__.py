"""Quadric vertex clustering as good numpy code does it: no loop over elements, sums by bincount.

The same grid, the same quadrics, the same placement and the same output order as the kernels; float32 where a value is
kept, float64 where numpy sums. Planes are made in blocks that stay in cache. No scipy: a sparse product is faster, and
would no longer be numpy.

Source: DeCoro & Tatarchuk 2007, slides 10-17.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Indices, TriangleMesh
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.harness.baselines.simplifier import found_grid, unchanged
from lodbench.kernels.cluster.borders import NO_EDGES, edges_of, used_once
from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.cluster.quadric_clustering import Params as KernelParams
from lodbench.kernels.cluster.quadric_clustering.params import Placement
from lodbench.kernels.cluster.quadric_clustering.reference import border_quadrics, simplify
from lodbench.kernels.cluster.quadric_clustering.verdict import verdict
from lodbench.kernels.cluster.survivors import host_survivors
from lodbench.kernels.cluster.target import ClusterTarget, GridTarget
from lodbench.kernels.cluster.unchanged import without_duplicates
from lodbench.kernels.opencl import Device, Timeline

_BLOCK = 1 << 14


@dataclass(frozen=True)
class Params(GridTarget, ClusterTarget):
    """How far and how to simplify; the words mean what they mean for the kernels.

    Attributes:
        placement: "robust", "paper" or "average".
        border: "quadrics" or "none".
    """

    placement: Placement = "robust"
    border: Literal["quadrics", "none"] = "quadrics"

    def kernel(self) -> KernelParams:
        """The kernels' parameters for the same output."""
        return KernelParams(
            self.cells, self.placement, border=self.border, remove_duplicates=self.remove_duplicates
        )


def cluster(
    mesh: TriangleMesh, params: Params, border: Indices
) -> tuple[NDArray[np.float32], NDArray[np.integer]]:
    """Positions (n, 3) and triangles (m, 3) of the simplified mesh, held by these border edges.

    Raises:
        ValueError: more than 2**27 cells.
    """
    grid = Grid.over(*mesh.box, params.grid_cells)
    points = np.ascontiguousarray(grid.points(mesh.positions).T)
    cells = grid.cells_of(points.T)

    marks = np.zeros(grid.cell_count, bool)
    marks[cells] = True
    occupied = np.flatnonzero(marks)
    rank_of = np.empty(grid.cell_count, np.intp)
    rank_of[occupied] = np.arange(len(occupied))
    ranks = rank_of[cells]

    triangles = np.ascontiguousarray(mesh.triangles.T, dtype=np.intp)
    a, b, c = corners = [ranks[corner] for corner in triangles]
    distinct = (a != b) & (b != c) & (c != a)
    survivors = np.stack([corner[distinct] for corner in corners], axis=1)
    used = np.zeros(len(occupied), bool)
    used[survivors.ravel()] = True

    # a vertex counts once for each corner it makes
    valence = sum(np.bincount(corner, minlength=mesh.vertex_count) for corner in triangles)
    count = np.maximum(np.bincount(ranks, valence, len(occupied)), 1)
    solved = np.stack(
        [np.bincount(ranks, valence * axis, len(occupied)) / count for axis in points]
    )
    if params.placement != "average":
        sums = np.zeros((9, len(occupied)))
        for total, values in zip(sums, planes(points, triangles), strict=True):
            for corner in corners:
                total += np.bincount(corner, values, len(occupied))
        if len(border):
            A, b = border_quadrics(points.T.astype(np.float64), border)
            lanes = (*A[:, (0, 0, 0, 1, 1, 2), (0, 1, 2, 1, 2, 2)].T, *b.T)
            for total, values in zip(sums, lanes, strict=True):
                for end in border[:, :2].T:
                    total += np.bincount(ranks[end], values, len(occupied))
        solved += steps(sums, solved, params.placement, 1 / grid.extent if grid.extent else 1.0)

    survivors = (np.cumsum(used) - 1)[survivors]
    if params.remove_duplicates:
        _, first = np.unique(np.sort(survivors, axis=1), axis=0, return_index=True)
        survivors = survivors[np.sort(first)]
    return grid.positions(solved[:, used].T), survivors


def planes(points: NDArray[np.float32], triangles: NDArray[np.intp]) -> NDArray[np.float64]:
    """Xx xy xz yy yz zz of area/3 n n^T and x y z of area/3 d n, (9, m), for points and triangles by column."""
    lanes = np.empty((9, triangles.shape[1]))
    for start in range(0, triangles.shape[1], _BLOCK):
        rows = slice(start, start + _BLOCK)
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (
            [axis[corner] for axis in points] for corner in triangles[:, rows]
        )
        ux, uy, uz = bx - ax, by - ay, bz - az
        vx, vy, vz = cx - ax, cy - ay, cz - az
        x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        d = -(x * ax + y * ay + z * az)
        length = np.sqrt(x * x + y * y + z * z)
        # no area, no plane: such a triangle counts at its corners alone
        weight = np.where(length > 1e-15, 1 / (6 * np.maximum(length, np.float32(1e-15))), 0)
        wx, wy, wz = x * weight, y * weight, z * weight
        for lane, product in enumerate(
            (x * wx, x * wy, x * wz, y * wy, y * wz, z * wz, d * wx, d * wy, d * wz)
        ):
            lanes[lane, rows] = product
    return lanes


def steps(
    sums: NDArray[np.float64], means: NDArray[np.float64], placement: str, per_box: float
) -> NDArray[np.float64]:
    """Steps from the means (3, n) to the representatives; the solve is written out, numpy's batched one is slower."""
    xx, xy, xz, yy, yz, zz, x, y, z = sums
    mx, my, mz = means
    x = x + xx * mx + xy * my + xz * mz
    y = y + xy * mx + yy * my + yz * mz
    z = z + xz * mx + yz * my + zz * mz
    trace = xx + yy + zz
    found = np.zeros_like(means)
    if placement == "paper":
        areas = np.stack([xx, xy, xz, yy, yz, zz, x, y, z]) * per_box**2
        with np.errstate(divide="ignore", invalid="ignore"):
            step, determinant = minimum(areas, 0.0)
        solvable = determinant > 1e-11
        found[:, solvable] = step[:, solvable]
        return found
    scaled = np.stack([xx, xy, xz, yy, yz, zz, x, y, z]) / np.maximum(trace, 1e-30)
    open_ = np.flatnonzero(trace > 1e-30)
    for ridge in (1e-3, 1e-2, 1e-1):
        step, _ = minimum(scaled[:, open_], ridge)
        taken = (step**2).sum(0) <= 1
        found[:, open_[taken]] = step[:, taken]
        open_ = open_[~taken]
    return found


def minimum(
    lanes: NDArray[np.float64], ridge: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """-(A + ridge I)^-1 b of each column by L D L^T, (3, n), and the determinants (n,)."""
    xx, xy, xz, yy, yz, zz, x, y, z = lanes
    d0 = xx + ridge
    l10, l20 = xy / d0, xz / d0
    d1 = yy + ridge - l10 * xy
    e21 = yz - l20 * xy
    l21 = e21 / d1
    d2 = zz + ridge - l20 * xz - l21 * e21
    u1 = y - l10 * x
    sz = -(z - l20 * x - l21 * u1) / d2
    sy = -u1 / d1 - l21 * sz
    sx = -x / d0 - l10 * sy - l20 * sz
    return np.stack([sx, sy, sz]), d0 * d1 * d2


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> HostPrepared:
    """The mesh as it is, and the grid found: everything else happens in the call."""
    setup = Timeline()
    with setup.host("search"):
        count = host_survivors(mesh, params.remove_duplicates)
        cells, counters = found_grid(mesh, params, count)
    if cells is None:
        kept = without_duplicates(mesh) if params.remove_duplicates else mesh
        return unchanged(device, kept, setup, counters)
    params = replace(params, target_reduction=None, target_count=None, cells=cells)
    with setup.host("borders"):
        border = NO_EDGES
        if params.kernel().holds_border:
            border = used_once(edges_of(mesh.triangles), mesh.positions)
    return HostPrepared(
        device,
        lambda _: cluster(mesh, params, border),
        read=lambda output: [TriangleMesh(*output)],
        verdict=lambda meshes: verdict(meshes[0], simplify(mesh, params.kernel())),
        setup=setup,
        input_bytes=mesh.positions.nbytes + mesh.triangles.nbytes,
        count=lambda _: counters,
    )


SYSTEM = host_system(
    "numpy_quadric_clustering",
    "DeCoro & Tatarchuk 2007, slides 10-17",
    prepare,
    {
        "cells_64": Params(64),
        "cells_30": Params(30),
        "cells_124": Params(124),
        "average_64": Params(64, placement="average"),
        "paper_64": Params(64, placement="paper"),
    },
)
