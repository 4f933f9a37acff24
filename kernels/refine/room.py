"""Has this machine room for a refined mesh? Asked before any work is done on it."""

from __future__ import annotations

import psutil

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.launching import VERTEX_BYTES
from lodbench.kernels.opencl import Device, Unsupported
from lodbench.kernels.refine.lattice import lattice_vertex_count, vertex_total

TRIANGLE_BYTES = 12
COARSE_BYTES = 88  # of a triangle while it is refined: corners with normals, and its indices
SHARING_BYTES = (
    280  # of a triangle while edges are matched: keys, their order and what numpy sorts them with
)


def host_bytes(mesh: TriangleMesh, segments: int, weld: bool) -> int:
    """Bytes that numpy holds at the most while `mesh` is refined and read back in one piece, within some per cent.

    Every refined vertex is counted as if no other shared it; welding holds the mesh of all instances beside the result.
    """
    extra = sum(
        4 * values.shape[1]
        for name in ("uvs", "colours", "tags")
        if (values := getattr(mesh, name)) is not None
    )
    vertices, triangles = vertex_total(mesh.triangle_count, segments), mesh.triangle_count
    refined = TRIANGLE_BYTES * triangles * segments**2
    held = (VERTEX_BYTES + 3 + extra) * vertices + refined  # 3: are they finite?
    held += COARSE_BYTES * triangles + (VERTEX_BYTES + TRIANGLE_BYTES) * mesh.vertex_count
    if not weld:
        return held
    matching = SHARING_BYTES * triangles + 8 * vertices
    taking = (4 + 8 + VERTEX_BYTES + extra) * vertices + refined
    return held + max(matching, taking)


def device_bytes(mesh: TriangleMesh, segments: int) -> int:
    """Bytes of the buffers for one pass: points and normals, the pattern, the corners."""
    pattern = 8 * lattice_vertex_count(segments) + TRIANGLE_BYTES * segments**2
    return (
        VERTEX_BYTES * vertex_total(mesh.triangle_count, segments)
        + pattern
        + (76 * mesh.triangle_count)
    )


def check_room(device: Device, mesh: TriangleMesh, segments: int, weld: bool = True) -> None:
    """Refuse a result that this machine could not hold.

    Raises:
        ValueError: more vertices than 32-bit indices can name.
        Unsupported: more bytes than the machine has left; a CPU's buffers are in the same memory.
    """
    needed = host_bytes(mesh, segments, weld)
    buffers = device_bytes(mesh, segments)
    free = device.memory_limit - device.used_bytes
    if buffers > free:  # several passes, each read and then joined
        needed += VERTEX_BYTES * vertex_total(mesh.triangle_count, segments)
    if device.is_cpu:
        needed += min(buffers, free)
    available = psutil.virtual_memory().available
    if needed > available:
        raise Unsupported(
            f"segments: needs {needed:,} bytes of memory for the result, machine has {available:,}"
        )
