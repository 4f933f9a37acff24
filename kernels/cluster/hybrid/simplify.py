"""The verb `simplify`: clustering and edge collapse as one call, with the map over both and the attributes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.attributes import carry, has_attributes
from lodbench.kernels.cluster.edge_collapse.seams import welded
from lodbench.kernels.cluster.hybrid.host import Hybrid
from lodbench.kernels.cluster.hybrid.params import Params
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

    `counters` holds `target` and `target_gap`, triangles short of it, negative where no further edge may go;
    `first_triangles`, what the clustering left, and `first_apart`, vertices of it that are less than a cell. Where all
    triangles are asked for the result is the mesh as it came.

    Args:
        device: where it runs.
        mesh: what is simplified.
        attributes: carry normals, uvs, colours and tags, where the mesh has them, as edge_collapse does.
        lock: (n,) of booleans: vertices that stay where they are.
        **options: of the Params.

    Raises:
        ValueError: a lock of another shape.
    """
    check("attributes", attributes, bool)
    params = Params.named(**options)
    locked = None if lock is None else np.asarray(lock)
    if locked is not None and (locked.shape != (mesh.vertex_count,) or locked.dtype != bool):
        got = f"{locked.dtype} {locked.shape}"
        raise ValueError(f"lock: expected booleans ({mesh.vertex_count},), got {got}")
    carrying = attributes and has_attributes(mesh)
    given, place = welded(mesh) if carrying else (mesh.bare(), None)
    if locked is not None and place is not None:
        locked = np.bincount(place, locked, given.vertex_count) > 0
    prepared = Hybrid(device, given, params, locked, warm=False)
    frame = run(device, prepared)
    if prepared.target >= mesh.triangle_count:
        simplified = mesh if attributes else mesh.bare()
        vertex_map = np.arange(mesh.vertex_count, dtype=np.uint32)
        counters = dict(prepared.counters())
        return Result(simplified, vertex_map, (simplified,), counters, prepared.setup, frame)
    (simplified,) = prepared.result()
    vertex_map, counters = prepared.vertex_map(), dict(prepared.counters())
    if carrying:
        assert place is not None
        with prepared.setup.host("attributes"):
            carried = carry(mesh, simplified, vertex_map[place], prepared.sources().astype(np.intp))
        simplified, vertex_map = carried.mesh, carried.vertex_map
        counters["split_vertices"] = carried.split
    counters["vertices"] = simplified.vertex_count
    return Result(simplified, vertex_map, (simplified,), counters, prepared.setup, frame)
