"""vtkQuadricClustering: one vertex per grid cell, at the minimum of the cell's summed quadric; one thread.

Source: PyPI package vtk; Lindstrom 2000, Out-of-core simplification of large polygonal models.
"""

from __future__ import annotations

from dataclasses import dataclass

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines import vtk_mesh
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.harness.baselines.simplifier import peer
from lodbench.harness.baselines.vtk_mesh import IndexBits
from lodbench.kernels.cluster.target import GridTarget
from lodbench.kernels.opencl import Device


@dataclass(frozen=True)
class Params(GridTarget):
    """A grid, or how many triangles it is to leave; `index_bits`: 32 or 64, of the input's cells."""

    index_bits: IndexBits = 64


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> HostPrepared:
    """The filter with its input set; the call runs it anew.

    Raises:
        Unsupported: the package is not installed.
    """
    quadrics = peer("vtkmodules.vtkFiltersCore", vtk_mesh.INSTALL).vtkQuadricClustering()
    return vtk_mesh.prepare(device, mesh, params, quadrics, params.index_bits)


SYSTEM = host_system(
    "vtk_quadric_clustering",
    "PyPI vtk, vtkQuadricClustering; Lindstrom 2000",
    prepare,
    {"default": Params()},
)
