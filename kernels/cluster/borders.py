"""Border edges, those that one triangle alone uses, found on the device: a closed mesh costs one look at it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Floats, Indices
from lodbench.kernels.opencl import Buffer, Device, Program, Timeline
from lodbench.kernels.stages.scan import chunk_count, chunk_local, map_count

NO_EDGES: Indices = np.zeros((0, 3), np.uint32)
NO_VERTICES = np.zeros(0, np.uint32)


def used_once(edges: Indices, positions: Floats) -> Indices:
    """The border edges among candidates, which hold every use of each.

    Where a seam of texture or of normals has parted the vertices, two edges lie between the same positions: no border.

    Args:
        edges: (k, 3) uint32: from, to, the third corner of the triangle.
        positions: of the mesh, (n, 3).

    Returns:
        (borders, 3) uint32 in the same order.
    """
    alone = edges[single(edges[:, :2])]
    vertices, ends = np.unique(alone[:, :2], return_inverse=True)
    return alone[single(places(positions[vertices])[ends].reshape(-1, 2))]


def places(positions: Floats) -> NDArray[np.intp]:
    """A number for each of (k, 3) positions, the same for those that are equal."""
    bits = (positions + np.float32(0)).view(np.uint32).astype(np.uint64)  # -0 is 0
    found = bits[:, 0]
    for axis in (1, 2):  # two sorts of one number each: quicker than one of rows
        _, found = np.unique(found << np.uint64(32) | bits[:, axis], return_inverse=True)
        found = found.astype(np.uint64)
    return found.astype(np.intp)


def single(pairs: NDArray[np.integer]) -> NDArray[np.bool_]:
    """Which (from, to) are those of one row alone, whichever way, and of two different ends?"""
    _, which, uses = np.unique(unordered(pairs), return_inverse=True, return_counts=True)
    return (uses[which] == 1) & (pairs[:, 0] != pairs[:, 1])


def unordered(pairs: NDArray[np.integer]) -> NDArray[np.uint64]:
    """A number for each (from, to), the same for both ways."""
    low, high = pairs.min(axis=1), pairs.max(axis=1)
    return low.astype(np.uint64) << np.uint64(32) | high.astype(np.uint64)


def edges_of(triangles: Indices) -> Indices:
    """Every edge of every triangle, (3 m, 3) uint32 in input order: from, to, the third corner."""
    return np.stack([np.roll(triangles, -k, axis=1) for k in range(3)], axis=1).reshape(-1, 3)


def edge_sums(device: Device, program: Program, triangles: Buffer) -> Buffer:
    """Sums over the edges of a mesh's triangles, (chunks, 2) uint32, for `cancel`; never waits.

    Args:
        device: where the mesh is.
        program: holds the kernels of `cluster/borders.cl`.
        triangles: uint32, (m, 3).
    """
    chunks = chunk_count(device, max(triangles.shape[0], 1))
    sums = device.allocate("sums", (chunks, 2), np.uint32)
    _launch(device, program, "sum", chunks, sums=sums, **_walked(triangles))
    return sums


def cancel(sums: NDArray[np.uint32]) -> bool:
    """Is each edge used as often in one direction as in the other? Then there is no border."""
    return not any(sum(column) % 2**32 for column in sums.T.tolist())


def border_edges(device: Device, program: Program, triangles: Buffer, positions: Floats) -> Indices:
    """The border edges of a mesh on the device, (borders, 3) uint32 in input order: from, to, the third corner.

    Where triangles turn against their neighbours it takes longer, and finds the same.

    Args:
        device: where the mesh is.
        program: holds the kernels of `cluster/borders.cl`.
        triangles: uint32, (m, 3).
        positions: of the mesh, (n, 3), on the host.
    """
    found = candidates(device, program, triangles, len(positions))
    return used_once(found, positions) if len(found) else NO_EDGES


def candidates(device: Device, program: Program, triangles: Buffer, vertex_count: int) -> Indices:
    """Edges of a mesh on the device that hold every use of each border edge, as `border_edges` has them; few."""
    chunks = chunk_count(device, max(triangles.shape[0], 1))
    maps, walkers = map_count(device, max(triangles.shape[0], 1))
    marks = device.allocate("marks", (maps, vertex_count), np.int32)
    device.fill(Timeline(), "borders", marks, 0)
    walked, shared = _walked(triangles), {"vertex_count": vertex_count, "map_count": maps}
    _launch(device, program, "mark", walkers, marks=marks, **shared, **walked)
    if maps > 1:
        _launch(device, program, "join", chunk_count(device, vertex_count), marks=marks, **shared)
    found = {"marks": marks, "chunk_sums": device.allocate("chunk_sums", chunks, np.uint32)}
    _launch(device, program, "count", chunks, **found, **walked)
    rows = int(device.read(found["chunk_sums"]).sum(dtype=np.int64))
    if not rows:
        return NO_EDGES
    edges = device.allocate("edges", (rows, 3), np.uint32)
    _launch(device, program, "write", chunks, edges=edges, **found, **walked)
    return device.read(edges)


def _walked(triangles: Buffer) -> dict[str, Any]:
    """The arguments of a kernel that walks over triangles, uint32, (m, 3)."""
    return {"triangles": triangles, "triangle_count": triangles.shape[0]}


def _launch(
    device: Device, program: Program, kernel: str, chunks: int, **arguments: Buffer | int
) -> None:
    program.launch(
        f"cluster_borders_{kernel}", chunks, stage="borders", local=chunk_local(device),
        chunk_count=chunks, **arguments,
    )(Timeline())  # fmt: skip


def border_vertices(edges: Indices) -> NDArray[np.uint32]:
    """The vertices of border edges, ascending."""
    return np.unique(edges[:, :2])
