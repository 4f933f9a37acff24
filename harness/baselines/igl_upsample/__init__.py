"""libigl's `upsample`: each triangle split in four where it lies, as often as it takes; welded, float64, one thread.

The surface is the coarse one, as that of `pattern`; normals are not made.

Source: PyPI package libigl, igl.upsample.
"""

from __future__ import annotations

from lodbench.harness.baselines.igl_mesh import subdivision
from lodbench.harness.baselines.subdivision import Params, subdivision_system

__all__ = ["Params", "SYSTEM"]

SYSTEM = subdivision_system(
    "igl_upsample",
    "PyPI libigl, igl.upsample",
    subdivision("upsample", linear=True),
    {"linear_16": Params(16)},
)
