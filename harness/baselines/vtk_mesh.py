"""What the VTK peers share: arrays in and out of a vtkPolyData, threads, and the grid."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, Literal, TypeAlias

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.host import HostPrepared
from lodbench.harness.baselines.simplifier import found_grid, meshes, peer, unchanged
from lodbench.harness.baselines.subdivision import Peer
from lodbench.kernels.cluster.grid import Cells
from lodbench.kernels.cluster.target import GridTarget
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.system import Check

INSTALL = "pip install vtk"
IndexBits: TypeAlias = Literal[32, 64]
MOST_CELLS = (
    2**25
)  # of a grid that a search tries: one filter keeps 88 bytes for each, occupied or not


def divisions(mesh: TriangleMesh, cells: Cells) -> tuple[int, int, int]:
    """Cells per axis: as given, or an int along the longest axis and as many as make them cubic along the others.

    The filters divide the box evenly, so a number that is not an int is rounded, up along x and less far along y and
    z: one axis changes at a time, and a search comes nearer to its count.
    """
    if isinstance(cells, tuple | list):
        return cells
    low, high = mesh.box
    extent = high - low
    longest = float(extent.max())
    if longest == 0:
        return (1, 1, 1)
    less = 0.0 if isinstance(cells, int) else np.array([0, 1, 2]) / 3
    along = np.ceil(extent / longest * cells - less - 1e-6)
    x, y, z = np.clip(along, 1, None).astype(int).tolist()
    return (x, y, z)


def prepare(
    device: Device, mesh: TriangleMesh, params: GridTarget, grid_filter: Any, index_bits: int
) -> HostPrepared:
    """A filter with a grid: its input set and its grid found; the call runs it anew.

    Where a number of triangles is asked for, the search runs the filter itself, timed apart as "search".
    """
    setup = Timeline()
    with setup.host("upload"):
        data = poly_data(mesh, index_bits)
    grid_filter.SetInputData(data)
    grid_filter.AutoAdjustNumberOfDivisionsOff()
    use_threads(device.facts.compute_units)

    def call(_: Any) -> Any:
        use_threads(device.facts.compute_units)
        if mesh.triangle_count:  # an empty input is an error to VTK
            grid_filter.Modified()
            grid_filter.Update()
        return grid_filter.GetOutput()

    @cache
    def left(grid: tuple[int, int, int]) -> int:
        grid_filter.SetNumberOfDivisions(*grid)
        return call(None).GetNumberOfPolys()

    with setup.host("search"):
        cells, counters = found_grid(
            mesh, params, lambda cells, stride: left(divisions(mesh, cells)) // stride, MOST_CELLS
        )
    if cells is None:
        return unchanged(device, mesh, setup, counters)
    grid = divisions(mesh, cells)
    grid_filter.SetNumberOfDivisions(*grid)
    return HostPrepared(
        device,
        call,
        read=read,
        verdict=one_vertex_per_cell(mesh, grid),
        setup=setup,
        input_bytes=data.GetActualMemorySize() * 1024,
        count=lambda _: counters,
    )


def subdivision(filter_name: str, linear: bool) -> Peer:
    """A peer that runs this filter of vtkFiltersModeling; its input is set beforehand, its cells 64-bit."""

    def start(mesh: TriangleMesh, times: int) -> Callable[[], Any]:
        subdivide = getattr(peer("vtkmodules.vtkFiltersModeling", INSTALL), filter_name)()
        subdivide.SetInputData(poly_data(mesh, 64))
        subdivide.SetNumberOfSubdivisions(times)

        def call() -> Any:
            subdivide.Modified()
            subdivide.Update()
            return subdivide.GetOutput()

        return call

    return Peer(start, read, linear)


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

    def verdict(result: Sequence[TriangleMesh]) -> Check:
        count = sum(part.vertex_count for part in result)
        excess = max(count - occupied, 0) / max(occupied, 1)
        return Check(
            excess <= 1e-3, "vertices above the occupied cells, share of them", excess, 1e-3
        )

    return verdict
