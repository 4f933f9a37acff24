"""From what a user asks of edge collapse to its subject, in the form for the device."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.edge_collapse.host import EdgeCollapse
from lodbench.kernels.cluster.edge_collapse.params import Params
from lodbench.kernels.cluster.edge_collapse.rounds import Rounds
from lodbench.kernels.cluster.unchanged import Unchanged
from lodbench.kernels.cluster.upload import Upload
from lodbench.kernels.opencl import Device
from lodbench.kernels.targets import missed


def prepare(
    device: Device,
    mesh: TriangleMesh,
    params: Params,
    locked: NDArray[np.bool_] | None = None,
    recorded: bool = False,
) -> EdgeCollapse | Unchanged:
    """The mesh uploaded and a frame ready to run; the mesh itself where all of its triangles may stay.

    Args:
        device: where it runs.
        mesh: what is simplified.
        params: how far, and how.
        locked: (n,), vertices that stay where they are.
        recorded: note the collapses, for `replay.py`.

    Raises:
        Unsupported: no room on the device.
    """
    upload = Upload(device, mesh)
    target = params.left(mesh.triangle_count)
    if target >= mesh.triangle_count:
        counters = {
            "vertices_in": mesh.vertex_count, "triangles_in": mesh.triangle_count,
            **missed(target, mesh.triangle_count),
        }  # fmt: skip
        setup = upload.setup
        return Unchanged(device, mesh, upload.positions, upload.triangles, setup, counters)
    form = Rounds if params.form_on(device.is_cpu) == "rounds" else EdgeCollapse
    with upload.setup.host("build"):
        upload.program = device.build(*form.files, defines=form.defines)
    return form(upload, params, target, locked, recorded)
