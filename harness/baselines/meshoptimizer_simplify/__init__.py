"""meshoptimizer's `simplify`: edge collapse by quadrics onto a subset of the input's vertices, one thread.

Source: PyPI package meshoptimizer (a pre-release; built from source, needs g++), meshopt_simplify; after Garland &
Heckbert 1997.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.harness.baselines.simplifier import asked, at_most, peer, used_only
from lodbench.kernels.opencl import Device
from lodbench.kernels.parameters import Range
from lodbench.kernels.targets import Target

INSTALL = "pip install --pre meshoptimizer"


@dataclass(frozen=True, kw_only=True)
class Params(Target):
    """`target_error`: stop at this error (share of the extent) even above the target; 1 never stops early."""

    target_error: Annotated[float, Range(0)] = 1.0


def prepare(
    device: Device, mesh: TriangleMesh, params: Params, function: str = "simplify"
) -> HostPrepared:
    """The package's `function` on a mesh; the output's index array is allocated here, as its callers do.

    Raises:
        Unsupported: the package is not installed.
    """
    package = peer("meshoptimizer", INSTALL)
    points, indices = mesh.positions, mesh.triangles.reshape(-1)
    kept = np.zeros_like(indices)
    target = asked(mesh, params)

    def call(_):
        if not len(indices):
            return 0
        return getattr(package, function)(
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
        # it stops where no collapse keeps the topology: a closed surface always has one to give
        verdict=at_most(target, slack=0.0 if params.target_error >= 1 else np.inf),
        input_bytes=points.nbytes + indices.nbytes,
    )


SYSTEM = host_system(
    "meshoptimizer_simplify",
    "PyPI meshoptimizer, meshopt_simplify; Garland & Heckbert 1997",
    prepare,
    {"default": Params()},
)
