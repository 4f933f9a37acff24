"""Quadric vertex clustering of a mesh that comes in batches: what it leaves is kept, the mesh itself is not.

The passes are those of `host.py`, over the same kernels. Integer sums are the same for any batches. Private maps add
their share of the whole mesh's triangles in order, one batch after the other, which gives the sums of one walk, bit for
bit: so a batch belongs to one map.

Source: Lindstrom 2000, Out-of-Core Simplification of Large Polygonal Models; the batches are ours.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.batches import Batch, MeshFile, ahead
from lodbench.kernels.cluster.batches import CellBatches, Tell
from lodbench.kernels.cluster.borders_stream import StreamBorders
from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.cluster.quadric_clustering.host import (
    BORDER_FIXED_POINT,
    FILES,
    FIXED_POINT,
    SUM_LANES,
    fixed_point_scale,
    float_maps,
    placing,
    squares_by_exponent,
)
from lodbench.kernels.cluster.quadric_clustering.params import HEAVINESS, Params
from lodbench.kernels.opencl import Buffer, Device, Timeline
from lodbench.kernels.stages.scan import chunk_count

_PREFIX = "quadric_clustering_"


class Batches(CellBatches):
    """The cluster map of one grid; between `rank` and `solve` come `accumulate`, then `hold_border`, for all batches.

    With integer sums `exponents` and `border_exponents` come before, for all batches too, then `scale`.

    Attributes:
        private: float maps, one per share of the triangles; else one map of integers, and any order of triangles.
        shares: how many private maps; 1 with integers.
    """

    FILES = FILES

    def __init__(
        self,
        device: Device,
        grid: Grid,
        params: Params,
        triangle_count: int,
        marked: NDArray[np.uint8] | None = None,
    ) -> None:
        """See `CellBatches`; integer sums need 64-bit atomics."""
        super().__init__(device, grid, params, triangle_count, marked)
        self.private = float_maps(device, params)
        self.shares = params.chunks if self.private else 1
        self._scale = (1.0, 1.0, 1.0)
        if not self.private:
            self._programs.append(device.build(FIXED_POINT, BORDER_FIXED_POINT))

    @staticmethod
    def weights(device: Device, params: Params) -> dict[str, float]:
        """See `CellBatches`."""
        if float_maps(device, params):
            return {"triangles": 12.0}
        return {"sizes": 8.0, "triangles": 50.0}

    def walk(
        self,
        source: MeshFile,
        rows: int,
        borders: StreamBorders | None,
        spill: BinaryIO,
        tell: Tell,
    ) -> int:
        """See `CellBatches`; `borders` add their planes after the triangles."""
        count = source.triangle_count
        if not self.private:
            exponents, squares, done = np.zeros(256), np.zeros(256), 0
            for batch in ahead(source.batches(0, count, rows)):
                exponents += self.exponents(batch.positions, batch.triangles)
                tell("sizes", (done := done + len(batch.triangles)) / count)
            for batch in borders.edges() if borders else ():
                squares += self.border_exponents(batch)
            self.scale(exponents, squares)
        left = done = 0
        for map in range(self.shares):
            for batch in ahead(source.batches(*self.share(map), rows)):
                found = self.accumulate(*batch, map)
                spill.write(found.data)
                left += len(found)
                tell("triangles", (done := done + len(batch.triangles)) / count)
        if borders is not None:
            first = 0
            for batch in borders.edges():
                self.hold_border(batch, first, borders.count)
                first += len(batch.triangles)
        return left

    def share(self, map: int, count: int | None = None) -> tuple[int, int]:
        """First and past-the-last triangle of a private map's share, or of `count`: `geometry_share` of share.cl."""
        count = self._triangles if count is None else count
        return count * map // self.shares, count * (map + 1) // self.shares

    def exponents(
        self,
        positions: NDArray[np.float32],
        triangles: NDArray[np.uint32],
    ) -> NDArray[np.float64]:
        """Triangles by the exponent of their area, (256,), which sums of all batches give `scale` its room."""
        if not len(triangles):
            return np.zeros(256)
        chunks = chunk_count(self.device, len(triangles))
        found = self.device.allocate("exponents", (chunks, 256), np.uint32)
        self._launch(
            _PREFIX + "setup_exponents", len(triangles), points=self._place(positions),
            triangles=self._upload("triangles", triangles), exponents=found,
            triangle_count=len(triangles),
        )(Timeline())  # fmt: skip
        return self.device.read(found).sum(0, dtype=np.float64)

    def border_exponents(self, edges: Batch) -> NDArray[np.float64]:
        """Border edges, as `StreamBorders` has them, by the exponent of the square of their length, (256,)."""
        return squares_by_exponent(self.grid.points(edges.positions)[edges.triangles[:, :2]])

    def scale(
        self, exponents: NDArray[np.float64], border: NDArray[np.float64] | None = None
    ) -> None:
        """The fixed point of integer sums, from what `exponents` and `border_exponents` gave of all batches."""
        border = np.zeros(256) if border is None else border
        self._scale = fixed_point_scale(exponents, self.grid, self._triangles, border)

    def _room(self) -> Buffer:
        """The cluster map, cleared when it is first asked for."""
        if not hasattr(self, "_sums"):
            rows = (self.shares, self.capacity, 16) if self.private else (self.capacity, SUM_LANES)
            kind = np.float32 if self.private else np.int64
            self._sums = self.device.allocate("maps", rows, kind)
            self.device.fill(Timeline(), "pass_1", self._sums, 0)
        return self._sums

    def accumulate(
        self,
        positions: NDArray[np.float32],
        triangles: NDArray[np.uint32],
        vertices: NDArray[np.integer] | int = 0,
        values: Mapping[str, NDArray[np.float32]] | None = None,
        map: int = 0,
    ) -> NDArray[np.uint32]:
        """The batch's quadrics added to its cells; returns the triangles left, as ranks of cells, (s, 3), in order.

        Args:
            positions: (k, 3).
            triangles: (m, 3), rows of positions.
            vertices: see `Batch`; of use where vertices are kept.
            values: see `Batch`.
            map: the private map whose share they belong to.
        """
        count, sums = len(triangles), self._room()
        if not count:
            return np.zeros((0, 3), np.uint32)
        device = self.device
        points, uploaded = self._place(positions, vertices), self._upload("triangles", triangles)
        self._carry(points, uploaded, values or {})
        read: dict[str, Any] = {"points": points, "triangles": uploaded, "triangle_count": count}
        if self.private:
            left = device.allocate("pieces", 3 * count + 4, np.uint32)
            counts = device.allocate("piece_counts", 1, np.uint32)
            name = _PREFIX + "geometry_batch"
            self.kernel(name).launch(
                name, 1, stage="batch", local=1, maps=sums, pieces=left, piece_counts=counts,
                map=map, capacity=self.capacity, **read,
            )(Timeline())  # fmt: skip
            return device.read(left, 3 * int(device.read(counts)[0])).reshape(-1, 3)
        name = _PREFIX + "geometry_fixed_point"
        self.kernel(name).launch(
            name, count, stage="batch", sums=sums, scale=(*self._scale, 0), **read
        )(Timeline())
        return self._left(points, uploaded)

    def hold_border(self, edges: Batch, first: int, count: int) -> None:
        """Border edges add their planes to the cells of their ends; all of them in order, after the triangles.

        Args:
            edges: a batch of them, as `StreamBorders` has them.
            first: its first one's place among all.
            count: all there are.
        """
        points, sums = self._place(edges.positions, edges.vertices), self._room()
        read = {"points": points, "heaviness": HEAVINESS}
        if not self.private:
            name, own = _PREFIX + "border_fixed_point", len(edges.triangles)
            self.kernel(name).launch(
                name, own, stage="batch", edges=self._upload("edges", edges.triangles), sums=sums,
                scale=(*self._scale, 0), edge_count=own, **read,
            )(Timeline())  # fmt: skip
            return
        name = _PREFIX + "border_batch"
        for map in range(self.shares):
            low, high = (max(row - first, 0) for row in self.share(map, count))
            if len(own := edges.triangles[low:high]):
                self.kernel(name).launch(
                    name, 1, stage="batch", local=1, edges=self._upload("edges", own), maps=sums,
                    map=map, capacity=self.capacity, edge_count=len(own), **read,
                )(Timeline())  # fmt: skip

    def sums(self) -> NDArray[np.int64]:
        """The integer sums, (capacity, 14), to be added to those of other batches."""
        return self.device.read(self._room())

    def merged(self, sums: NDArray[np.int64]) -> None:
        """Sums of all batches that were added up elsewhere take the place of those here."""
        self._sums = self.device.upload("sums", sums, np.int64)

    def solved(self) -> tuple[Buffer, Buffer]:
        """See `CellBatches`."""
        device, capacity = self.device, self.capacity
        solved = device.allocate("solved", (capacity, 4), np.float32)
        chunk_sums = device.allocate("chunk_sums", chunk_count(device, capacity), np.uint32)
        limits = device.allocate("limits", 3, np.float32)  # of a warped grid alone
        own: dict[str, Any] = {"maps": self._room(), "map_count": self.shares}
        kernel = _PREFIX + "fragment_solve"
        if not self.private:
            own = {"sums": self._room(), "inverse_scale": (*(1 / s for s in self._scale), 0)}
            kernel += "_fixed_point"
        self._launch(
            kernel, capacity, limits=limits, solved=solved, state=self._state,
            chunk_sums=chunk_sums, capacity=capacity, **own, **placing(self.grid, self.params),
        )(Timeline())  # fmt: skip
        return solved, chunk_sums
