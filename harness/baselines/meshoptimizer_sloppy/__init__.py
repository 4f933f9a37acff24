"""meshoptimizer's `simplify_sloppy`: vertex clustering on the finest grid that keeps the target, one thread.

Source: PyPI package meshoptimizer (a pre-release; built from source, needs g++), meshopt_simplifySloppy; after
Rossignac & Borrel 1993.
"""

from __future__ import annotations

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.host import HostPrepared
from lodbench.harness.baselines.meshoptimizer_simplify import INSTALL, Params
from lodbench.harness.baselines.simplifier import at_most, peer, used_only
from lodbench.kernels.device import Device
from lodbench.kernels.system import System


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> HostPrepared:
    """The output's index array is allocated here, as the library's callers do.

    Raises:
        Unsupported: the package is not installed.
    """
    package = peer("meshoptimizer", INSTALL)
    points, indices = mesh.positions, mesh.triangles.reshape(-1)
    kept = np.zeros_like(indices)
    target = params.triangles(mesh)

    def call(_):
        if not len(indices):
            return 0
        return package.simplify_sloppy(
            kept,
            indices,
            points,
            target_index_count=3 * target,
            target_error=params.target_error,
        )

    return HostPrepared(
        device,
        call,
        read=lambda count: used_only(points, kept[:count].reshape(-1, 3)),
        judge=at_most(target, slack=0.0 if params.target_error >= 1 else np.inf),
        input_bytes=points.nbytes + indices.nbytes,
    )


SYSTEM = System(
    name="meshoptimizer_sloppy",
    family="baselines",
    source="PyPI meshoptimizer, meshopt_simplifySloppy; Rossignac & Borrel 1993",
    takes=(TriangleMesh,),
    prepare=prepare,
    cases={"default": Params()},
    runs_on="host",
)
