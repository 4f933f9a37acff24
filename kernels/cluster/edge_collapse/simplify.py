"""The verb `simplify`: the mesh as it is asked for, with the map to it and its attributes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.attributes import carry, has_attributes
from lodbench.kernels.cluster.edge_collapse.host import EdgeCollapse
from lodbench.kernels.cluster.edge_collapse.params import Params
from lodbench.kernels.cluster.edge_collapse.prepare import prepare
from lodbench.kernels.cluster.edge_collapse.seams import welded
from lodbench.kernels.opencl import Device
from lodbench.kernels.parameters import check
from lodbench.kernels.result import Result
from lodbench.kernels.system import run


def simplify(
    device: Device,
    mesh: TriangleMesh,
    *,
    attributes: bool = True,
    lock: ArrayLike | None = None,
    **options: Any,
) -> Result:
    """The simplified mesh, by a number of triangles; other options are those of the Params.

    `counters` holds `target` and `target_gap`, triangles short of it, negative where no further edge may go; `sweeps`
    and `collapses`. Where all triangles are asked for the result is the mesh as it came.

    Args:
        device: where it runs.
        mesh: what is simplified.
        attributes: carry normals, uvs, colours and tags, where the mesh has them, as `cluster/attributes.py` says: what
            a seam parts is simplified as one, and split again; `split_vertices` counts those that stand for a side.
        lock: (n,) of booleans: vertices that stay where they are.
        **options: of the Params.

    Raises:
        ValueError: a lock of another shape.
    """
    check("attributes", attributes, bool)
    locked = None if lock is None else np.asarray(lock)
    if locked is not None and (locked.shape != (mesh.vertex_count,) or locked.dtype != bool):
        got = f"{locked.dtype} {locked.shape}"
        raise ValueError(f"lock: expected booleans ({mesh.vertex_count},), got {got}")
    carrying = attributes and has_attributes(mesh)
    given, place = welded(mesh) if carrying else (mesh, None)
    if locked is not None and place is not None:
        locked = np.bincount(place, locked, given.vertex_count) > 0
    params = Params.named(**options)
    prepared = prepare(
        device, given, params, locked, place=place, of=None if place is None else mesh
    )
    if isinstance(prepared, EdgeCollapse):
        prepared.map_vertices()
    frame = run(device, prepared, wait=prepared.live)
    (simplified,) = prepared.result()
    vertex_map, counters = prepared.vertex_map(), dict(prepared.counters())
    if not isinstance(prepared, EdgeCollapse):
        simplified = mesh if attributes else mesh.bare()
        vertex_map = np.arange(mesh.vertex_count, dtype=np.uint32)
    elif carrying:
        with prepared.setup.host("attributes"):
            vertex_map = vertex_map[place]
            carried = carry(mesh, simplified, vertex_map, prepared.sources().astype(np.intp))
        simplified, vertex_map = carried.mesh, carried.vertex_map
        counters["split_vertices"] = carried.split
    counters["vertices"] = simplified.vertex_count
    return Result(simplified, vertex_map, (simplified,), counters, prepared.setup, frame)
