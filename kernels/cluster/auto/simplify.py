"""The verb `simplify`: the chosen method's, with points at the same place joined where the mesh would be in pieces."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.attributes import has_attributes
from lodbench.kernels.cluster.auto.choice import BOTH, EDGES, choose
from lodbench.kernels.cluster.auto.host import asked
from lodbench.kernels.cluster.borders import (
    border_vertices,
    cancel,
    candidates,
    edge_sums,
    places,
)
from lodbench.kernels.cluster.edge_collapse.seams import joined
from lodbench.kernels.cluster.upload import SHARED
from lodbench.kernels.opencl import Device
from lodbench.kernels.result import Counters, Result
from lodbench.kernels.targets import Target


def simplify(device: Device, mesh: TriangleMesh, **options: Any) -> Result:
    """The simplified mesh, by the method that `choice.py` takes; options are those of the methods.

    `counters` has `took_<method>` and `because_<reason>`, 1 each, beside the method's own.

    Where a mesh without attributes has borders, points on them at the same place are one: an STL file, or a scan parted
    along its texture's seams, would fall to pieces else. Others stay apart, as sheets that touch are to.

    Args:
        device: where it runs.
        mesh: what is simplified.
        **options: of the methods; what only one of them takes decides for it.

    Raises:
        TypeError, ValueError: an option that no method takes, or as the method says.
    """
    given = {name: value for name, value in options.items() if value is not None}
    goal = {name: given[name] for name in ("target_reduction", "target_count") if name in given}
    target = asked(Target.named(**goal), mesh.triangle_count)
    choice = choose(mesh, target, given)
    plain = not has_attributes(mesh) or not given.get("attributes", True)
    given_mesh, place = mesh, None
    if choice.system in (EDGES, BOTH) and plain and 0 < target < mesh.triangle_count:
        given_mesh, place = joined_places(device, mesh.bare())
        if place is not None and "lock" in given:
            locked = np.bincount(place, np.asarray(given["lock"], bool), given_mesh.vertex_count)
            given["lock"] = locked > 0
    result = choice.system.verbs["simplify"](device, given_mesh, **given)
    if place is not None and result.vertex_map is not None:
        result = replace(result, vertex_map=result.vertex_map[place])
    taken = {f"took_{choice.system.name}": 1, f"because_{choice.why}": 1}
    more = result.counters
    counters = more.also(taken) if isinstance(more, Counters) else {**more, **taken}
    return replace(result, counters=counters)


def joined_places(
    device: Device, mesh: TriangleMesh
) -> tuple[TriangleMesh, NDArray[np.intp] | None]:
    """The mesh with one vertex for each place on its borders, and the vertex of each before; None where all differ.

    Vertices inside the surface stay apart from others, as sheets that touch are to.
    """
    program = device.build(*SHARED)
    triangles = device.upload("triangles", mesh.triangles, np.uint32, (None, 3), lent=True)
    if cancel(device.read(edge_sums(device, program, triangles))):
        return mesh, None
    vertices = border_vertices(candidates(device, program, triangles, mesh.vertex_count))
    return joined(mesh, vertices, places(mesh.positions[vertices]))
