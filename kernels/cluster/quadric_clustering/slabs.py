"""The cluster map filled slab by slab: the work of a frame's largest stage for any number of cores, in private's bits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lodbench.kernels.cluster.quadric_clustering.params import Params
from lodbench.kernels.opencl import Buffer, Device
from lodbench.kernels.stages.scan import CHUNK_ROWS, chunk_local
from lodbench.kernels.subject import POINT, WORD

if TYPE_CHECKING:
    from lodbench.kernels.cluster.quadric_clustering.host import QuadricClustering

FILE = "cluster/quadric_clustering/geometry_slabs.cl"
BINS = 1024  # as the kernels have it: what slabs are made of
BLOCK = 128  # triangles in a block of a list, as the kernels have it
MOST_SLABS = 256
PER_CORE = 2  # slabs, so that a core with an easy one takes another
SAMPLES = 16  # items that take them
SAMPLED = 1 << 14  # triangles by whose corners slabs are cut
_PREFIX = "quadric_clustering_geometry_slabs_"


def chosen(device: Device, params: Params) -> str:
    """How this device accumulates where `params` leave it open: "private", "slabs" or "fixed_point".

    Private maps keep as many cores busy as there are maps, and slabs all of them, at a price: they pay from about
    twice as many cores as maps. That was measured on two cores, where they do not, and projected from there.
    """
    if params.accumulate != "auto":
        return params.accumulate
    if not device.is_cpu:
        return "fixed_point"
    return "private" if device.facts.compute_units < 2 * params.chunks else "slabs"


def slab_count(device: Device, params: Params, triangles: int) -> int:
    """Slabs for a mesh of so many triangles; any number gives the same bits."""
    wanted = min(triangles // CHUNK_ROWS, PER_CORE * device.facts.compute_units)
    return params.slabs or min(max(wanted, 1), MOST_SLABS)


def add_slabs(subject: QuadricClustering) -> Buffer:
    """Adds the steps that list the triangles of each slab and sum them, and gives the maps that they fill.

    ```
    samples       uint  [chunks, BINS]          corners of some triangles by bins of cells
    bounds        uint  [slabs + 1]             first cell of each slab
    lists         uint  [blocks, BLOCK, 3]      triangles that touch a slab, in order; links: the block after
    heads         uint  [chunks, slabs, 2]      first block and length of a chunk's list
    maps          float [maps * capacity + slabs, 16]
    ```

    A chunk is a whole share of one map's triangles, or a part of one: so each cell is summed as one item per map would.
    """
    device, params, upload = subject.device, subject.params, subject._upload
    capacity, count = subject.capacity, upload.mesh.triangle_count
    slabs = slab_count(device, params, count)
    chunks = params.chunks * -(-slabs // params.chunks)
    blocks = 3 * count // BLOCK + (slabs + 1) * chunks
    mesh = {"triangles": upload.triangles, "triangle_count": count}
    samples = subject.allocate("samples", (SAMPLES, BINS), np.uint32)
    bounds = subject.allocate("bounds", slabs + 1, np.uint32)
    lists = {
        "lists": subject.allocate("lists", (blocks, BLOCK, 3), np.uint32),
        "links": subject.allocate("links", blocks, np.uint32),
        "heads": subject.allocate("heads", (chunks, slabs, 2), np.uint32),
    }
    maps = subject.allocate("maps", (params.chunks * capacity + slabs, 16), np.float32)
    shift = max(0, (capacity - 1).bit_length() - BINS.bit_length() + 1)

    def add(kernel: str, items: int, amounts: dict[str, int], **arguments: Any) -> None:
        program = subject.program(_PREFIX + kernel)
        launch = program.launch(
            _PREFIX + kernel, items, stage=subject.first, local=chunk_local(device),
            points=subject.points, **arguments,
        )  # fmt: skip
        subject.add(launch, **amounts)

    cut = {"samples": samples, "sample_count": SAMPLES, "shift": shift}
    add("sample", SAMPLES, {}, stride=max(1, count // SAMPLED), **mesh, **cut)  # fmt: skip
    add("list", chunks, {"bytes": WORD * count}, bounds=bounds, slab_count=slabs, capacity=capacity, emit=3 * subject.fused, chunk_count=chunks,
        **mesh, **cut, **subject.pieces(chunks), **lists)  # fmt: skip
    add("sum", slabs, {"bytes": POINT * count + subject.points.size_bytes + maps.size_bytes},
        bounds=bounds, maps=maps, map_count=params.chunks, capacity=capacity, slab_count=slabs,
        chunk_count=chunks, **lists)  # fmt: skip
    return maps
