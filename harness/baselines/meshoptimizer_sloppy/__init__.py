"""meshoptimizer's `simplify_sloppy`: vertex clustering on the finest grid that keeps the target, one thread.

Source: PyPI package meshoptimizer (a pre-release; built from source, needs g++), meshopt_simplifySloppy; after
Rossignac & Borrel 1993.
"""

from __future__ import annotations

from functools import partial

from lodbench.harness.baselines import meshoptimizer_simplify
from lodbench.harness.baselines.host import host_system
from lodbench.harness.baselines.meshoptimizer_simplify import Params

SYSTEM = host_system(
    "meshoptimizer_sloppy",
    "PyPI meshoptimizer, meshopt_simplifySloppy; Rossignac & Borrel 1993",
    partial(meshoptimizer_simplify.prepare, function="simplify_sloppy"),
    {"default": Params()},
)
