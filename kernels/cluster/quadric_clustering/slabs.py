"""The cluster map filled slab by slab: the largest stage of a frame for any number of cores, with private's bits."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.cluster.clustering import Clustering
from lodbench.kernels.cluster.quadric_clustering.params import Params
from lodbench.kernels.cluster.upload import Upload
from lodbench.kernels.opencl import Buffer, Device
from lodbench.kernels.stages.scan import CHUNK_ROWS, chunk_local
from lodbench.kernels.subject import POINT

FILE = "cluster/quadric_clustering/geometry_slabs.cl"
BINS = 1024  # as the kernels have it: what slabs are made of
BLOCK = 128  # triangles in a block of a list, as the kernels have it
MOST_SLABS = 256
WALK_FLOPS = 112  # a triangle: 70 for a plane and its products, 14 sums at each of 3 corners
SAMPLES = 16  # items that sample
SAMPLED = 256  # triangles for each slab, by whose corners slabs are cut
_PREFIX = "quadric_clustering_geometry_slabs_"


def chosen(device: Device, params: Params, triangles: int) -> str:
    """How so many triangles are accumulated where `params` leave it open: "private", "slabs" or "fixed_point".

    Private maps keep as many cores busy as there are maps, and slabs as many as there are slabs, for 1.4 times the work
    or more: they pay from more than twice as many slabs as maps. Measured on two cores; the rest is the projection of
    `harness/tables/scaling.py`.
    """
    if params.accumulate != "auto":
        return params.accumulate
    if not device.is_cpu:
        return "fixed_point"
    return "slabs" if slab_count(device, params, triangles) > 2 * params.chunks else "private"


def slab_count(device: Device, params: Params, triangles: int) -> int:
    """Slabs for a mesh of so many triangles: one for each core, since more would list more triangles twice.

    Any number gives the same bits.
    """
    wanted = min(triangles // CHUNK_ROWS, device.facts.compute_units)
    return params.slabs or min(max(wanted, 1), MOST_SLABS)


@dataclass(frozen=True)
class Slabs:
    """What the walk leaves on the device.

    ```
    bounds        uint  [slabs + 1]             first cell of each slab
    lists         uint  [blocks, BLOCK, 3]      triangles that touch a slab, in order
    links         uint  [blocks]                the block that follows in its list
    heads         uint  [chunks, slabs, 2]      first block and triangles of a chunk's list
    maps          float [maps * capacity + slabs, 16]   the cluster map; a row of each slab for what is not its own
    ```
    """

    bounds: Buffer
    lists: Buffer
    links: Buffer
    heads: Buffer
    maps: Buffer

    def listed(self, device: Device, slab: int) -> NDArray[np.uint32]:
        """Triangles of a slab, (n, 3), chunk after chunk, as the last frame listed them."""
        heads = device.read(self.heads)[:, slab]
        lists, links = device.read(self.lists), device.read(self.links)
        found = [np.zeros((0, 3), np.uint32)]
        for block, left in heads.tolist():
            while left:
                found.append(lists[block, : min(left, BLOCK)])
                left -= len(found[-1])
                block = links[block] if left else block
        return np.concatenate(found)


def add_slabs(
    subject: Clustering,
    upload: Upload,
    params: Params,
    stage: str,
    emit: bool,
    pieces: Callable[[int], Mapping[str, Buffer]],
) -> Slabs:
    """Adds the steps that list the triangles of each slab and sum its cells.

    A chunk of triangles is a map's whole share or a part of it, so each cell is summed as one item per map would do.

    Args:
        subject: that has its cells.
        upload: its mesh.
        params: how many maps, and slabs.
        stage: what the steps count towards.
        emit: note survivors on the way.
        pieces: room for those of so many chunks.
    """
    device, capacity = subject.device, subject.capacity
    count, vertices = upload.mesh.triangle_count, upload.mesh.vertex_count
    slabs = slab_count(device, params, count)
    chunks = params.chunks * -(-slabs // params.chunks)
    blocks = 3 * count // BLOCK + (slabs + 1) * chunks
    shift = max(0, (capacity - 1).bit_length() - BINS.bit_length() + 1)
    mesh: dict[str, Any] = {
        "triangles": upload.triangles,
        "triangle_count": count,
        "chunk_count": chunks,
    }
    sampled: dict[str, Any] = {
        "samples": subject.allocate("samples", (min(SAMPLES, chunks), BINS), np.uint32),
        "sample_count": min(SAMPLES, chunks),
        "shift": shift,
    }
    ranks = subject.allocate("ranks", vertices, np.uint32)
    lists: dict[str, Any] = {
        "lists": subject.allocate("lists", (blocks, BLOCK, 3), np.uint32),
        "links": subject.allocate("links", blocks, np.uint32),
        "heads": subject.allocate("heads", (chunks, slabs, 2), np.uint32),
    }
    cells: dict[str, Any] = {
        "bounds": subject.allocate("bounds", slabs + 1, np.uint32),
        "slab_count": slabs,
        "capacity": capacity,
    }
    maps = subject.allocate("maps", (params.chunks * capacity + slabs, 16), np.float32)

    def add(kernel: str, items: int, bytes: int, flops: int = 0, **arguments: Any) -> None:
        launch = subject.program(_PREFIX + kernel).launch(
            _PREFIX + kernel, items, stage=stage, local=chunk_local(device), **arguments
        )
        subject.add(launch, bytes, flops)

    add("ranks", chunks, 0, points=subject.points, ranks=ranks, vertex_count=vertices,
        stride=max(1, count // (SAMPLED * slabs)), **sampled, **mesh)  # fmt: skip
    noted: dict[str, Any] = {"emit": 3 * emit, **pieces(chunks)}  # words of a survivor
    add("list", chunks, POINT * count, ranks=ranks, **noted, **sampled, **cells, **mesh, **lists)
    add("sum", slabs, subject.points.size_bytes + maps.size_bytes, WALK_FLOPS * count,
        points=subject.points, maps=maps, map_count=params.chunks, chunk_count=chunks,
        **lists, **cells)  # fmt: skip
    return Slabs(cells["bounds"], maps=maps, **lists)
