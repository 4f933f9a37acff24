"""vtkLoopSubdivisionFilter: Loop's scheme, each triangle split in four and its vertices moved; welded, float32.

It is smooth, and another surface than that of curved PN triangles: it needs neighbours instead of normals, and does not
go through the given vertices. It runs on one thread.

Source: PyPI package vtk, vtkLoopSubdivisionFilter; Loop 1987, Smooth subdivision surfaces based on triangles.
"""

from __future__ import annotations

from lodbench.harness.baselines.subdivision import Params, subdivision_system
from lodbench.harness.baselines.vtk_mesh import subdivision

__all__ = ["Params", "SYSTEM"]

SYSTEM = subdivision_system(
    "vtk_loop_subdivision",
    "PyPI vtk, vtkLoopSubdivisionFilter; Loop 1987",
    subdivision("vtkLoopSubdivisionFilter", linear=False),
    {"loop_16": Params(16)},
)
