"""From what a user asks of edge collapse to its subject, in the form for the device."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.edge_collapse.bound import Limit, within_bound
from lodbench.kernels.cluster.edge_collapse.fit import Input
from lodbench.kernels.cluster.edge_collapse.host import EdgeCollapse
from lodbench.kernels.cluster.edge_collapse.params import Params
from lodbench.kernels.cluster.edge_collapse.penalties import penalties, weighted
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
    place: NDArray[np.intp] | None = None,
    of: TriangleMesh | None = None,
    to: Input | None = None,
) -> EdgeCollapse | Unchanged:
    """The mesh uploaded and a frame ready to run; the mesh itself where all of its triangles may stay.

    With `max_error` that is the last of several tries (`bound.py`), whose frames were run and compared here.

    Args:
        device: where it runs.
        mesh: what is simplified.
        params: how far, and how.
        locked: (n,), vertices that stay where they are.
        recorded: note the collapses, for `replay.py`.
        place: with `of`, see `penalties`; None: the mesh has its attributes itself.
        of: the mesh with the attributes.
        to: what vertices are fitted to in the end; None: the mesh.

    Raises:
        Unsupported: no room on the device.
        ValueError: a weight of attributes that the mesh has not.
    """
    upload = Upload(device, mesh)
    target = params.left(mesh.triangle_count)
    if target >= mesh.triangle_count:
        return _unchanged(upload, params, target)
    form = Rounds if params.form_on(device.is_cpu) == "rounds" else EdgeCollapse
    with upload.setup.host("build"):
        upload.program = device.build(*form.files, defines=form.defines)
    held = None
    if weighted(params):
        with upload.setup.host("penalties"):
            places = np.arange(mesh.vertex_count) if place is None else place
            held = penalties(mesh if of is None else of, places, params)

    def make(limit: Limit | None = None) -> EdgeCollapse:
        return form(upload, params, target, locked, recorded, limit, held, to)

    if params.max_error is None:
        return make()
    with upload.setup.host("search"):
        found = within_bound(device, mesh, params, make)
    return found or _unchanged(upload, params, target)


def _unchanged(upload: Upload, params: Params, target: int) -> Unchanged:
    mesh = upload.mesh
    counters = {
        "vertices_in": mesh.vertex_count, "triangles_in": mesh.triangle_count,
        **(missed(target, mesh.triangle_count) if params.targeted else {}),
    }  # fmt: skip
    return Unchanged(
        upload.device, mesh, upload.positions, upload.triangles, upload.setup, counters
    )
