"""How many triangles a grid leaves, as the search asks for it: on the device, or on the host by numpy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.opencl import Buffer, Device, Launch, Program, Timeline
from lodbench.kernels.stages.scan import chunk_count, chunk_local

FILE = "cluster/search.cl"
_NO_TRIANGLE = 0xFFFFFFFF


class DeviceSurvivors:
    """Counting passes over a mesh in device memory; calling it with cells and a stride counts."""

    def __init__(
        self,
        device: Device,
        program: Program,
        positions: Buffer,
        triangles: Buffer,
        box: tuple[NDArray[np.float64], NDArray[np.float64]],
        remove_duplicates: bool = False,
        kept: NDArray[np.uint32] | None = None,
    ) -> None:
        """Room for the counts, and their launches.

        Args:
            device: where the mesh is.
            program: holds the kernels of `FILE`.
            positions: float32, (n, 3).
            triangles: uint32, (m, 3).
            box: lower and upper corner of all positions.
            remove_duplicates: of triangles with the same three cells, count one.
            kept: vertices that are in no cell but stay by themselves.
        """
        self._device, self._box = device, box
        local = chunk_local(device)
        vertex_count, self._triangle_count = positions.shape[0], triangles.shape[0]
        ids = device.allocate("cell_ids", vertex_count, np.uint32)
        chunks = chunk_count(device, vertex_count)
        self._cells = program.launch(
            "cluster_search_cells", chunks, stage="search", local=local,
            positions=positions, cell_ids=ids, vertex_count=vertex_count, chunk_count=chunks,
            **Grid.over(*box, 1).arguments,
        )  # fmt: skip
        self._keep: Launch | None = None
        if kept is not None and len(kept):
            rows = chunk_count(device, len(kept))
            self._keep = program.launch(
                "cluster_borders_keep_ids", rows, stage="search", local=local,
                kept=device.upload("kept", kept), cell_ids=ids, kept_count=len(kept),
                chunk_count=rows,
            )  # fmt: skip
        chunks = chunk_count(device, self._triangle_count)
        self._survivors = device.allocate("survivors", chunks, np.uint32)
        self._slots: Buffer | None = None
        name, more = "cluster_search_survivors", {}
        if remove_duplicates:
            slot_count = 2 << max(self._triangle_count, 1).bit_length()
            self._slots = device.allocate("slots", slot_count, np.uint32)
            name = "cluster_search_distinct"
            more: dict[str, Any] = {"slots": self._slots, "slot_mask": slot_count - 1}
        self._count = program.launch(
            name, chunks, stage="search", local=local, cell_ids=ids, triangles=triangles,
            survivors=self._survivors, stride=1, sample_count=self._triangle_count,
            chunk_count=chunks, **more,
        )  # fmt: skip

    def __call__(self, cells: float, stride: int = 1) -> int:
        """Of every `stride`-th triangle those that the grid of `cells` leaves."""
        self._cells.set(**Grid.over(*self._box, cells).arguments)
        self._count.set(stride=stride, sample_count=-(-self._triangle_count // stride))
        self._cells(Timeline())
        if self._keep is not None:
            self._keep(Timeline())
        if self._slots is not None:
            self._device.fill(Timeline(), "search", self._slots, _NO_TRIANGLE)
        self._count(Timeline())
        return int(self._device.read(self._survivors).sum(dtype=np.int64))


def host_survivors(
    mesh: TriangleMesh, remove_duplicates: bool = False
) -> Callable[[float, int], int]:
    """The same counts by numpy, bit for bit, for what runs on no device."""

    def count(cells: float, stride: int = 1) -> int:
        grid = Grid.over(*mesh.box, cells)
        corners = grid.cells_of(grid.points(mesh.positions))[mesh.triangles[::stride]]
        a, b, c = corners.T
        left = corners[(a != b) & (b != c) & (c != a)]
        return len(np.unique(np.sort(left, axis=1), axis=0)) if remove_duplicates else len(left)

    return count
