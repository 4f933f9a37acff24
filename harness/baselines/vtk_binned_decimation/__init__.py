"""vtkBinnedDecimation: one vertex per grid cell, without quadrics; over all threads.

Which integer type of the input's cells is the quicker one differs between machines and versions: both are cases, and
a fair comparison takes the better.

Source: PyPI package vtk; Rossignac & Borrel 1993.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines import vtk_mesh
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.harness.baselines.simplifier import peer
from lodbench.harness.baselines.vtk_mesh import IndexBits
from lodbench.kernels.cluster.target import GridTarget
from lodbench.kernels.opencl import Device

POINTS = {"bin_points": 2, "bin_centers": 3, "bin_averages": 4}


@dataclass(frozen=True)
class Params(GridTarget):
    """A grid, or how many triangles it is to leave, and what stands for a cell.

    Attributes:
        points: "bin_points" (one of the cell's vertices), "bin_centers" or "bin_averages".
        index_bits: 32 or 64, of the input's cells.
    """

    points: Literal["bin_points", "bin_centers", "bin_averages"] = "bin_points"
    index_bits: IndexBits = 32


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> HostPrepared:
    """The filter with its input set; the call runs it anew.

    Raises:
        Unsupported: the package is not installed.
    """
    bins = peer("vtkmodules.vtkFiltersCore", vtk_mesh.INSTALL).vtkBinnedDecimation()
    bins.SetPointGenerationMode(POINTS[params.points])
    bins.ProducePointDataOff()
    bins.ProduceCellDataOff()
    return vtk_mesh.prepare(device, mesh, params, bins, params.index_bits)


SYSTEM = host_system(
    "vtk_binned_decimation",
    "PyPI vtk, vtkBinnedDecimation; Rossignac & Borrel 1993",
    prepare,
    {
        "bin_points": Params(),
        "bin_averages": Params(points="bin_averages"),
        "bin_points_int64": Params(index_bits=64),
        "bin_averages_int64": Params(points="bin_averages", index_bits=64),
    },
)
