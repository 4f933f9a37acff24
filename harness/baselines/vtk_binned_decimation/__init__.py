"""vtkBinnedDecimation: one vertex per grid cell, without quadrics; over all threads.

Which integer type of the input's cells is the quicker one differs between machines and versions: both are cases, and
a fair comparison takes the better.

Source: PyPI package vtk; Rossignac & Borrel 1993.
"""

from __future__ import annotations

from dataclasses import dataclass

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines import vtk_mesh
from lodbench.harness.baselines.host import HostPrepared
from lodbench.harness.baselines.simplifier import peer
from lodbench.kernels.device import Device
from lodbench.kernels.stages.timeline import Timeline
from lodbench.kernels.system import System

POINTS = {"bin_points": 2, "bin_centers": 3, "bin_averages": 4}


@dataclass(frozen=True)
class Params:
    """A grid, and what stands for a cell.

    Attributes:
        cells: along the longest axis, or (nx, ny, nz).
        points: "bin_points" (one of the cell's vertices), "bin_centers" or "bin_averages".
        index_bits: 32 or 64, of the input's cells.
    """

    cells: int | tuple[int, int, int] = 64
    points: str = "bin_points"
    index_bits: int = 32

    def __post_init__(self) -> None:
        if self.points not in POINTS:
            raise ValueError(f"points: expected one of {', '.join(POINTS)}, got {self.points!r}")


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> HostPrepared:
    """The filter with its input set; the call runs it anew.

    Raises:
        Unsupported: the package is not installed.
    """
    filters = peer("vtkmodules.vtkFiltersCore", vtk_mesh.INSTALL)
    grid = vtk_mesh.divisions(mesh, params.cells)
    setup = Timeline()
    with setup.host("upload"):
        data = vtk_mesh.poly_data(mesh, params.index_bits)
    bins = filters.vtkBinnedDecimation()
    bins.SetInputData(data)
    bins.AutoAdjustNumberOfDivisionsOff()
    bins.SetNumberOfDivisions(*grid)
    bins.SetPointGenerationMode(POINTS[params.points])
    bins.ProducePointDataOff()
    bins.ProduceCellDataOff()

    def call(_):
        vtk_mesh.use_threads(device.facts.compute_units)
        if mesh.triangle_count:
            bins.Modified()
            bins.Update()
        return bins.GetOutput()

    return HostPrepared(
        device,
        call,
        read=vtk_mesh.read,
        judge=vtk_mesh.one_vertex_per_cell(mesh, grid),
        setup=setup,
        input_bytes=data.GetActualMemorySize() * 1024,
    )


SYSTEM = System(
    name="vtk_binned_decimation",
    family="baselines",
    source="PyPI vtk, vtkBinnedDecimation; Rossignac & Borrel 1993",
    takes=(TriangleMesh,),
    prepare=prepare,
    cases={
        "bin_points": Params(),
        "bin_averages": Params(points="bin_averages"),
        "bin_points_int64": Params(index_bits=64),
        "bin_averages_int64": Params(points="bin_averages", index_bits=64),
    },
    runs_on="host",
)
