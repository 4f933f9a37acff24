"""The whole of `simplify_mesh` on an open device: host arrays in, upload, frame, read-back, host arrays out.

What a caller waits for, and so what stands beside a package that is called the same way: positions and triangles
alone. The program is compiled and the device open, as at any call but the first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.harness.baselines.simplifier import at_most
from lodbench.harness.measure.quality import topology
from lodbench.kernels.api import simplify_mesh
from lodbench.kernels.cluster.quadric_clustering import SYSTEM as QUADRIC_CLUSTERING
from lodbench.kernels.cluster.quadric_clustering import Params as Clustering
from lodbench.kernels.cluster.target import GridTarget
from lodbench.kernels.opencl import Device
from lodbench.kernels.system import Check, Timeline, run

TARGET_COUNTERS = ("target", "target_gap", "counting_passes", "cells_along_longest")
SAID = ("took_", "because_", "first_")  # what methods made of others say of themselves


@dataclass(frozen=True)
class Params(GridTarget):
    """How far to go; a search for a grid is part of the call.

    `method`: the system that is called; `manifold`: part the sheets that meet, see `kernels/cluster/manifold.py`.
    """

    method: str = "quadric_clustering"
    manifold: bool = False


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> HostPrepared:
    """One call made already, so that those that are timed find everything compiled."""
    target = params.triangles(mesh.triangle_count)
    cells = params.cells if target is not None else params.grid_cells
    asked = {**vars(params), "cells": cells}
    if not params.manifold:
        del asked["manifold"]  # which not every method has
    setup = Timeline()
    with setup.host("first_launch"):
        simplify_mesh(device, mesh, attributes=False, **asked)

    def verdict(meshes: Sequence[TriangleMesh]) -> Check:
        if params.manifold:
            met = sum(topology(made)["nonmanifold_edges"] for made in meshes)
            return Check(met == 0, "edges of more than two triangles", met, 0)
        if params.method != QUADRIC_CLUSTERING.name:
            return at_most(mesh.triangle_count if target is None else target, slack=0.0)(meshes)
        own = {name: value for name, value in asked.items() if name != "method"}
        prepared = QUADRIC_CLUSTERING.prepare(device, mesh, Clustering(**own))
        run(device, prepared)
        (expected,), (got,) = prepared.result(), meshes
        pairs = ((expected.positions, got.positions), (expected.triangles, got.triangles))
        differ = sum(
            int(np.any(a != b, axis=1).sum()) if a.shape == b.shape else max(len(a), len(b))
            for a, b in pairs
        )
        return Check(differ == 0, "points and triangles unlike the system's own", differ, 0)

    return HostPrepared(
        device,
        lambda _: simplify_mesh(device, mesh, attributes=False, **asked),
        read=lambda result: [result.mesh],
        verdict=verdict,
        setup=setup,
        input_bytes=mesh.positions.nbytes + mesh.triangles.nbytes,
        count=lambda result: {
            name: value
            for name, value in result.counters.items()
            if name in TARGET_COUNTERS or name.startswith(SAID)
        },
    )


SYSTEM = host_system(
    "simplify_call",
    "lodbench.kernels.simplify_mesh",
    prepare,
    {
        "cells_64": Params(64),
        "cells_30": Params(30),
        "manifold": Params(30, manifold=True),
        "auto": Params(method="auto", target_reduction=0.9),
    },
    notes="wall time of the whole call, transfers included",
)
