"""fast-simplification: edge collapse by quadrics in sweeps with a rising threshold, one thread.

The threshold is absolute, 1e-9 (sweep + 3)^aggressiveness for 100 sweeps, so what comes out depends on the model's
units. The default aggressiveness of 7 raises it fast; 3 takes a few per cent longer and leaves a fraction of the error,
so both are cases; but with 3 the last threshold is 1e-3, and a large model or a far target is not reached. That case
therefore works in units in which the longest side is 2. trimesh and pyfqmr run the same algorithm: they are no further
independent peers.

Source: PyPI package fast-simplification (Forstmann's Fast-Quadric-Mesh-Simplification, after Garland & Heckbert 1997).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.harness.baselines.simplifier import asked, at_most, meshes, peer
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.parameters import Range
from lodbench.kernels.targets import Target


@dataclass(frozen=True, kw_only=True)
class Params(Target):
    """How the package is called.

    Attributes:
        aggressiveness: exponent of the threshold's growth, the package's `agg`.
        longest_side: the model is scaled to this size before, and back after, untimed; None leaves its units.
    """

    aggressiveness: Annotated[float, Range(0)] = 7
    longest_side: Annotated[float, Range(0, open="low")] | None = None


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> HostPrepared:
    """Arrays in the dtypes that the package takes without converting.

    Raises:
        Unsupported: the package is not installed.
    """
    package = peer("fast_simplification", "pip install fast-simplification")
    setup = Timeline()
    with setup.host("upload"):
        low, high = mesh.box
        side = float((high - low).max())
        scale = params.longest_side / side if params.longest_side and side else 1.0
        points = mesh.positions.astype(np.float64) * scale
        faces = mesh.triangles.astype(np.int32)
    target = asked(mesh, params)
    # below the default the sweeps may end first: then no more is promised than the input's own count
    slack = 0.0 if params.aggressiveness >= 7 else mesh.triangle_count / max(target, 1) - 1

    def call(_):
        if target >= len(faces):  # also the empty mesh, on which the package fails
            return points, faces
        return package.simplify(points, faces, target_count=target, agg=params.aggressiveness)

    return HostPrepared(
        device,
        call,
        read=lambda output: meshes(output[0] / scale, output[1]),
        verdict=at_most(target, slack),
        setup=setup,
        input_bytes=points.nbytes + faces.nbytes,
    )


SYSTEM = host_system(
    "fast_simplification",
    "PyPI fast-simplification; Garland & Heckbert 1997",
    prepare,
    {"default": Params(), "careful": Params(aggressiveness=3, longest_side=2.0)},
)
