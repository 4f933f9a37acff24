"""vtkLinearSubdivisionFilter: each triangle split in four where it lies; welded, float32, one thread.

The surface is the coarse one, as that of `pattern`; normals are not made.

Source: PyPI package vtk, vtkLinearSubdivisionFilter.
"""

from __future__ import annotations

from lodbench.harness.baselines.subdivision import Params, subdivision_system
from lodbench.harness.baselines.vtk_mesh import subdivision

__all__ = ["Params", "SYSTEM"]

SYSTEM = subdivision_system(
    "vtk_linear_subdivision",
    "PyPI vtk, vtkLinearSubdivisionFilter",
    subdivision("vtkLinearSubdivisionFilter", linear=True),
    {"linear_16": Params(16)},
)
