"""What the VTK peers share: arrays in and out of a vtkPolyData, threads, and the grid."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.simplifier import meshes, peer
from lodbench.kernels.system import Check

INSTALL = "pip install vtk"


def divisions(mesh: TriangleMesh, cells: int | tuple[int, int, int]) -> tuple[int, int, int]:
    """Cells per axis: as given, or an int along the longest axis and as many as make them cubic along the others."""
    if not isinstance(cells, int):
        return cells
    low, high = mesh.box
    extent = high - low
    longest = float(extent.max())
    if longest == 0:
        return (1, 1, 1)
    x, y, z = np.clip(np.ceil(extent / longest * cells - 1e-6), 1, None).astype(int).tolist()
    return (x, y, z)


def poly_data(mesh: TriangleMesh, index_bits: int) -> Any:
    """The mesh as vtkPolyData, its cells in the integer type asked for."""
    core = peer("vtkmodules.vtkCommonCore", INSTALL)
    model = peer("vtkmodules.vtkCommonDataModel", INSTALL)
    to_vtk = peer("vtkmodules.util.numpy_support", INSTALL).numpy_to_vtk
    kind = {32: np.int32, 64: np.int64}[index_bits]
    points, cells, data = core.vtkPoints(), model.vtkCellArray(), model.vtkPolyData()
    points.SetData(to_vtk(np.array(mesh.positions), deep=True))
    cells.SetData(
        to_vtk(np.arange(0, 3 * mesh.triangle_count + 1, 3, dtype=kind), deep=True),
        to_vtk(mesh.triangles.reshape(-1).astype(kind), deep=True),
    )
    data.SetPoints(points)
    data.SetPolys(cells)
    return data


def use_threads(count: int) -> None:
    """Let VTK's parallel loops use `count` threads: the wheel's default back end is sequential."""
    tools = peer("vtkmodules.vtkCommonCore", INSTALL).vtkSMPTools
    if tools.GetBackend() != "STDThread":
        tools.SetBackend("STDThread")
    if tools.GetEstimatedNumberOfThreads() != count:
        tools.Initialize(count)


def read(output: Any) -> list[TriangleMesh]:
    """A vtkPolyData of triangles as one mesh.

    Raises:
        ValueError: not finite, or an index out of range.
    """
    to_numpy = peer("vtkmodules.util.numpy_support", INSTALL).vtk_to_numpy
    if not output.GetNumberOfPolys():
        return meshes(np.zeros((0, 3)), np.zeros((0, 3), int))
    points = to_numpy(output.GetPoints().GetData())
    return meshes(points, to_numpy(output.GetPolys().GetConnectivityArray()).astype(np.int64))


def one_vertex_per_cell(
    mesh: TriangleMesh, grid: tuple[int, int, int]
) -> Callable[[Sequence[TriangleMesh]], Check]:
    """Judge: no more vertices than the grid has cells with input in them.

    One in a thousand is allowed: a vertex on the border of two cells may fall to either side by rounding.
    """
    low, high = mesh.box
    edge = np.where(high > low, (high - low) / grid, 1.0)
    cell = np.clip(((mesh.positions - low) / edge).astype(np.int64), 0, np.array(grid) - 1)
    occupied = len(np.unique(cell @ [1, grid[0], grid[0] * grid[1]]))

    def judge(result: Sequence[TriangleMesh]) -> Check:
        count = sum(part.vertex_count for part in result)
        excess = max(count - occupied, 0) / max(occupied, 1)
        return Check(
            excess <= 1e-3, "vertices above the occupied cells, share of them", excess, 1e-3
        )

    return judge
