"""libigl's `loop`: Loop's scheme, each triangle split in four and its vertices moved; welded, float64, one thread.

It is smooth, and another surface than that of curved PN triangles: it needs neighbours instead of normals, and does not
go through the given vertices.

Source: PyPI package libigl, igl.loop; Loop 1987, Smooth subdivision surfaces based on triangles.
"""

from __future__ import annotations

from lodbench.harness.baselines.igl_mesh import subdivision
from lodbench.harness.baselines.subdivision import Params, subdivision_system

__all__ = ["Params", "SYSTEM"]

SYSTEM = subdivision_system(
    "igl_loop",
    "PyPI libigl, igl.loop; Loop 1987",
    subdivision("loop", linear=False),
    {"loop_16": Params(16)},
)
