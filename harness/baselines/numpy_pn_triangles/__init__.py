"""Curved PN triangles as one writes them in NumPy: control nets times weights, blocked.

Points are (3 m, 10) control coordinates by (10, n) weights, normals (3 m, 6) by (6, n) and brought to unit length. The
nets and the weights are made once, before the clock starts, as the kernels make theirs.

Source: Vlachos et al. 2001, sections 3.1 and 3.3, on NumPy.
"""

from __future__ import annotations

from lodbench.harness.baselines.curved import control_weights, controls
from lodbench.harness.baselines.gemm import Evaluated, Params, gemm_system
from lodbench.kernels.refine.pn_triangles.reference import curved

__all__ = ["Params", "SYSTEM"]

SYSTEM = gemm_system(
    "numpy_pn_triangles",
    "the method of Vlachos et al. 2001, sections 3.1 and 3.3, on NumPy",
    Evaluated(controls, control_weights, curved),
    {"quadratic_16": Params(16), "quadratic_64": Params(64)},
)
