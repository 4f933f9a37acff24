"""vtkQuadricClustering: one vertex per grid cell, at the minimum of the cell's summed quadric; one thread.

Source: PyPI package vtk; Lindstrom 2000, Out-of-core simplification of large polygonal models.
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


@dataclass(frozen=True)
class Params:
    """`cells`: along the longest axis, or (nx, ny, nz); `index_bits`: 32 or 64, of the input's cells."""

    cells: int | tuple[int, int, int] = 64
    index_bits: int = 64


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
    quadrics = filters.vtkQuadricClustering()
    quadrics.SetInputData(data)
    quadrics.AutoAdjustNumberOfDivisionsOff()
    quadrics.SetNumberOfDivisions(*grid)
    vtk_mesh.use_threads(device.facts.compute_units)

    def call(_):
        vtk_mesh.use_threads(device.facts.compute_units)
        if mesh.triangle_count:  # an empty input is an error to VTK
            quadrics.Modified()
            quadrics.Update()
        return quadrics.GetOutput()

    return HostPrepared(
        device,
        call,
        read=vtk_mesh.read,
        judge=vtk_mesh.one_vertex_per_cell(mesh, grid),
        setup=setup,
        input_bytes=data.GetActualMemorySize() * 1024,
    )


SYSTEM = System(
    name="vtk_quadric_clustering",
    family="baselines",
    source="PyPI vtk, vtkQuadricClustering; Lindstrom 2000",
    takes=(TriangleMesh,),
    prepare=prepare,
    cases={"default": Params()},
    runs_on="host",
)
