"""pyfqmr: the same sweeps of edge collapses as fast-simplification, another binding; no independent peer.

Source: PyPI package pyfqmr (Forstmann's Fast-Quadric-Mesh-Simplification, after Garland & Heckbert 1997).
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
    """`aggressiveness`: exponent of the threshold's growth; `preserve_border`: open edges stay."""

    aggressiveness: Annotated[float, Range(0)] = 7
    preserve_border: bool = False


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> HostPrepared:
    """Arrays in the dtypes that the package keeps; handing them over is part of the call.

    Raises:
        Unsupported: the package is not installed.
    """
    package = peer("pyfqmr", "pip install pyfqmr")
    setup = Timeline()
    with setup.host("upload"):
        points = mesh.positions.astype(np.float64)
        faces = mesh.triangles.astype(np.int32)
    target = asked(mesh, params)

    def call(_):
        if target >= len(faces):
            return points, faces
        simplifier = package.Simplify()
        simplifier.setMesh(points, faces)
        simplifier.simplify_mesh(
            target_count=target,
            aggressiveness=params.aggressiveness,
            preserve_border=params.preserve_border,
            verbose=False,
        )
        return simplifier.getMesh()[:2]

    return HostPrepared(
        device,
        call,
        read=lambda output: meshes(*output),
        verdict=at_most(target, slack=0.0),
        setup=setup,
        input_bytes=points.nbytes + faces.nbytes,
    )


SYSTEM = host_system(
    "pyfqmr",
    "PyPI pyfqmr; Garland & Heckbert 1997",
    prepare,
    {"default": Params()},
)
