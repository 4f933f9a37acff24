"""Where is a mesh no surface? The vertices whose triangles are not one fan, found on the device."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Indices
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.stages.scan import chunk_count, chunk_local

FILE = "cluster/links.cl"
_NO_CORNER = 0xFFFFFFFF
MOST = 48  # triangles at a vertex; those with more are called troubled


def troubled(device: Device, triangles: Indices, vertex_count: int) -> NDArray[np.bool_]:
    """Vertices around which triangles are not one fan, (n,); `reference` says the same in few words.

    Args:
        device: where it runs.
        triangles: (m, 3) uint32, no vertex twice in one.
        vertex_count: n.
    """
    count, found = len(triangles), Timeline()
    if not count:
        return np.zeros(vertex_count, bool)
    program, local = device.build(FILE), chunk_local(device)
    given = device.upload("triangles", triangles, np.uint32, (None, 3), lent=True)
    heads = device.allocate("heads", vertex_count, np.uint32)
    chained = device.allocate("next", 3 * count, np.uint32)
    result = device.allocate("troubled", vertex_count, np.uint8)
    corners = {"triangles": given, "heads": heads, "next": chained}
    device.fill(found, "links", heads, _NO_CORNER)
    for kernel, rows, more in (
        ("chain", count, {"triangle_count": count}),
        ("test", vertex_count, {"vertex_count": vertex_count, "troubled": result}),
    ):
        chunks = chunk_count(device, rows)
        program.launch(
            f"cluster_links_{kernel}", chunks, stage="links", local=local, chunk_count=chunks,
            **corners, **more,
        )(found)  # fmt: skip
    return device.read(result).astype(bool)


def reference(triangles: Indices, vertex_count: int) -> NDArray[np.bool_]:
    """The same, vertex by vertex: the edges opposite it must be one path, or one ring of three at least."""
    around: list[list[tuple[int, int]]] = [[] for _ in range(vertex_count)]
    for a, b, c in np.asarray(triangles).tolist():
        for vertex, edge in ((a, (b, c)), (b, (c, a)), (c, (a, b))):
            around[vertex].append(edge)
    return np.array([bool(edges) and not _one_fan(edges) for edges in around], bool)


def _one_fan(edges: list[tuple[int, int]]) -> bool:
    following, before = dict(edges), {b: a for a, b in edges}
    if not len(following) == len(before) == len(edges) <= MOST:
        return False
    first = next((a for a in following if a not in before), edges[0][0])
    at, steps = following[first], 1
    while at in following and at != first:
        at, steps = following[at], steps + 1
    return steps == len(edges) and (at != first or steps > 2)
