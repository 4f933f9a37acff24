"""Refinement by pattern as one writes it in NumPy: corners times weights, (3 m, 3) by (3, n), for points and normals.

Source: the method of Boubekeur & Schlick 2005, section 3.2, on NumPy.
"""

from __future__ import annotations

import numpy as np

from lodbench.datasets_gen.surfaces import Floats, TriangleMesh
from lodbench.harness.baselines.gemm import Evaluated, Params, gemm_system
from lodbench.kernels.refine.pattern.reference import flat

__all__ = ["Params", "SYSTEM"]


def _corners(mesh: TriangleMesh) -> tuple[Floats, Floats]:
    """P0 P1 P2 and N0 N1 N2 of each triangle, (m, 3, 3) each."""
    normals = np.asarray(mesh.normals, np.float32)
    return mesh.positions[mesh.triangles], normals[mesh.triangles]


SYSTEM = gemm_system(
    "numpy_pattern",
    "the method of Boubekeur & Schlick 2005, section 3.2, on NumPy",
    Evaluated(_corners, lambda wuv: (wuv, wuv), flat),
    {"flat_16": Params(16), "flat_64": Params(64), "flat_128": Params(128)},
)
