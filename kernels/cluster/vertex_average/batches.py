"""Vertex clustering with means of a mesh that comes in batches: the sums of `host.py`, vertices in their order.

Private maps add their share of the whole file's vertices, one batch after the other, which gives the sums of one walk,
bit for bit.

Source: Lindstrom 2000, Out-of-Core Simplification of Large Polygonal Models; the batches are ours.
"""

from __future__ import annotations

from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.batches import MeshFile, ahead
from lodbench.kernels.cluster.batches import CellBatches, Tell
from lodbench.kernels.cluster.borders_stream import StreamBorders
from lodbench.kernels.cluster.vertex_average.host import FILES
from lodbench.kernels.cluster.vertex_average.params import Params
from lodbench.kernels.opencl import Buffer, Device, Timeline
from lodbench.kernels.stages.scan import chunk_count


class Batches(CellBatches):
    """The sums of each cell's vertices, and whether a surviving triangle uses it."""

    FILES = FILES
    SHARED_ONLY = True

    @staticmethod
    def weights(device: Device, params: Params) -> dict[str, float]:
        """See `CellBatches`."""
        return {"means": 4.0, "triangles": 8.0}

    def walk(
        self,
        source: MeshFile,
        rows: int,
        borders: StreamBorders | None,
        spill: BinaryIO,
        tell: Tell,
    ) -> int:
        """See `CellBatches`."""
        device, params, count = self.device, self.params, source.triangle_count
        self._maps = device.allocate("maps", (params.chunks, self.capacity, 8), np.float32)
        self._used = device.allocate("used", self.capacity, np.uint8)
        for buffer in (self._maps, self._used):
            device.fill(Timeline(), "pass_1", buffer, 0)
        done = 0
        for positions in ahead(source.positions()):
            self.add(positions, done, source.vertex_count)
            tell("means", (done := done + len(positions)) / source.vertex_count)
        left = done = 0
        for batch in ahead(source.batches(0, count, rows)):
            points = self._place(batch.positions)
            triangles = self._upload("triangles", batch.triangles)
            own = len(batch.triangles)
            self._launch(
                "cluster_emit_mark", own, points=points, triangles=triangles, used=self._used,
                triangle_count=own,
            )(Timeline())  # fmt: skip
            self._carry(points, triangles, batch.values)
            found = self._left(points, triangles)
            spill.write(found.data)
            left += len(found)
            tell("triangles", (done := done + own) / count)
        return left

    def add(self, positions: NDArray[np.float32], first: int, count: int) -> None:
        """Vertices (k, 3), the first of which is number `first` of `count`, added to their cells' sums."""
        name = "vertex_average_mean_batch"
        for map in range(self.params.chunks):
            low, high = (max(row - first, 0) for row in share(map, self.params.chunks, count))
            if len(own := positions[low:high]):
                self.kernel(name).launch(
                    name, 1, stage="batch", local=1, points=self._place(own), maps=self._maps,
                    map=map, vertex_count=len(own), capacity=self.capacity,
                )(Timeline())  # fmt: skip

    def solved(self) -> tuple[Buffer, Buffer]:
        """See `CellBatches`."""
        device, capacity = self.device, self.capacity
        solved = device.allocate("solved", (capacity, 4), np.float32)
        chunk_sums = device.allocate("chunk_sums", chunk_count(device, capacity), np.uint32)
        self._launch(
            "vertex_average_mean_place", capacity, maps=self._maps, used=self._used,
            state=self._state, solved=solved, chunk_sums=chunk_sums,
            map_count=self.params.chunks, capacity=capacity,
        )(Timeline())  # fmt: skip
        return solved, chunk_sums


def share(map: int, maps: int, count: int) -> tuple[int, int]:
    """First and past-the-last of a map's share of `count` vertices: `chunk_rows` of common/chunk.cl."""
    lines = (count + 15) // 16
    each = -(-lines // maps) * 16
    return min(map * each, count), min((map + 1) * each, count)
