"""vtkQuadricDecimation: edge collapse by quadrics, cheapest first from one queue; one thread.

Source: PyPI package vtk; Garland & Heckbert 1997, Hoppe 1999.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines import vtk_mesh
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.harness.baselines.simplifier import asked, at_most, peer, unchanged
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.targets import Target, missed


@dataclass(frozen=True, kw_only=True)
class Params(Target):
    """How many triangles it is to leave."""


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> HostPrepared:
    """The filter with its input set; the call runs it anew.

    Raises:
        Unsupported: the package is not installed.
    """
    decimate = peer("vtkmodules.vtkFiltersCore", vtk_mesh.INSTALL).vtkQuadricDecimation()
    setup, target = Timeline(), asked(mesh, params)
    if target >= mesh.triangle_count:
        return unchanged(device, mesh, setup, missed(target, mesh.triangle_count))
    with setup.host("upload"):
        data = vtk_mesh.poly_data(mesh, 64)
    decimate.SetInputData(data)
    decimate.SetTargetReduction(1 - target / mesh.triangle_count)

    def call(_: Any) -> Any:
        decimate.Modified()
        decimate.Update()
        return decimate.GetOutput()

    return HostPrepared(
        device,
        call,
        read=vtk_mesh.read,
        verdict=at_most(target, 0.0),
        setup=setup,
        input_bytes=data.GetActualMemorySize() * 1024,
    )


SYSTEM = host_system(
    "vtk_quadric_decimation",
    "PyPI vtk, vtkQuadricDecimation; Garland & Heckbert 1997",
    prepare,
    {"default": Params()},
)
