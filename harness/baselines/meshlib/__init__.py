"""MeshLib's `decimateMesh`: edge collapse that may be split over threads.

The package is free for non-commercial use only, so that no extra of this project installs it: `pip install meshlib`
where its licence allows what is done with it.

Source: PyPI package meshlib (MeshInspector/MeshLib), mrmeshpy.decimateMesh.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.harness.baselines.simplifier import asked, at_most, meshes, peer
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.parameters import Range
from lodbench.kernels.targets import Target

LARGEST = 3.4e38  # no limit on the error


@dataclass(frozen=True, kw_only=True)
class Params(Target):
    """`parts`: of the mesh, decimated apart at first, in threads."""

    parts: Annotated[int, Range(1, 1024)] = 8


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> HostPrepared:
    """The package's own mesh is made in the call, as it changes in place; arrays are read back in it too.

    Raises:
        Unsupported: the package is not installed.
    """
    install = "pip install meshlib (free for non-commercial use only)"
    package, arrays = (peer(f"meshlib.{name}", install) for name in ("mrmeshpy", "mrmeshnumpy"))
    setup = Timeline()
    with setup.host("upload"):
        points = mesh.positions.astype(np.float32)
        faces = mesh.triangles.astype(np.int32)
    target = asked(mesh, params)

    def call(_: Any) -> Any:
        made = arrays.meshFromFacesVerts(faces, points)
        settings = package.DecimateSettings()
        settings.maxDeletedFaces = max(len(faces) - target, 0)
        settings.maxError = LARGEST
        settings.subdivideParts = params.parts
        settings.packMesh = True
        if target < len(faces):
            package.decimateMesh(made, settings)
        return arrays.getNumpyVerts(made), arrays.getNumpyFaces(made.topology)

    return HostPrepared(
        device,
        call,
        read=lambda output: meshes(*output),
        verdict=at_most(target, slack=0.01),
        setup=setup,
        input_bytes=points.nbytes + faces.nbytes,
    )


SYSTEM = host_system(
    "meshlib",
    "PyPI meshlib, decimateMesh",
    prepare,
    {"default": Params()},
    notes="free for non-commercial use only",
)
