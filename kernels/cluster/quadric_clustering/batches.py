"""Quadric vertex clustering of a mesh that comes in batches: what it leaves is kept, the mesh itself is not.

The passes are those of `host.py`, over the same kernels. Integer sums are the same for any batches. Private maps add
their share of the whole mesh's triangles in order, one batch after the other, which gives the sums of one walk, bit for
bit: so a batch belongs to one map.

Source: Lindstrom 2000, Out-of-Core Simplification of Large Polygonal Models; the batches are ours.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.cluster.quadric_clustering.host import (
    FILES,
    FIXED_POINT,
    SUM_LANES,
    fixed_point_scale,
    float_maps,
    placing,
)
from lodbench.kernels.cluster.quadric_clustering.params import Params
from lodbench.kernels.cluster.upload import SHARED
from lodbench.kernels.opencl import Buffer, Device, Launch, Timeline
from lodbench.kernels.stages.scan import chunk_count, chunk_local

_PREFIX = "quadric_clustering_"


class Batches:
    """The cluster map of one grid; call in this order, each for all batches: `mark`, `rank`, `accumulate`, `solve`.

    With integer sums `exponents` comes before `accumulate`, for all batches too.

    Attributes:
        grid: the grid.
        private: float maps, one per share of the triangles; else one map of integers, and any order of triangles.
        shares: how many private maps; 1 with integers.
        occupied: cells with a vertex, known from `rank` on.
    """

    def __init__(
        self,
        device: Device,
        grid: Grid,
        params: Params,
        triangle_count: int,
        marked: NDArray[np.uint8] | None = None,
    ) -> None:
        """Room for the grid's marks.

        Args:
            device: where it runs.
            grid: over the box of the whole mesh.
            params: all but how far to simplify.
            triangle_count: of the whole mesh.
            marked: what `marked` gave, of all vertices; None starts with no cell marked.

        Raises:
            Unsupported: no room, or no 64-bit atomics where they are needed.
        """
        self.device, self.grid, self.params = device, grid, params
        self.private = float_maps(device, params)
        self.shares = params.chunks if self.private else 1
        self._triangles, self._count = triangle_count, 0
        self._scale = (1.0, 1.0, 1.0)
        self._edges = np.zeros(2, np.uint32)
        programs = [device.build(*FILES, *SHARED)]
        if not self.private:
            programs.append(device.build(FIXED_POINT))
        self._owner = {name: program for program in programs for name in program.kernels}
        self._word_count = -(-grid.cell_count // 64)
        if marked is None:
            self._marks: Buffer | None = device.allocate("marks", 64 * self._word_count, np.uint8)
            device.fill(Timeline(), "pass_1", self._marks, 0)
        else:
            self._marks = device.upload("marks", np.unpackbits(marked), np.uint8)

    def share(self, map: int) -> tuple[int, int]:
        """First and past-the-last triangle of a private map's share: `geometry_share` of share.cl."""
        count = self._triangles
        return count * map // self.shares, count * (map + 1) // self.shares

    def _launch(self, kernel: str, rows: int, **arguments: Any) -> Launch:
        """A launch of one item per chunk of `rows`."""
        chunks = chunk_count(self.device, rows)
        return self._owner[kernel].launch(
            kernel, chunks, stage="batch", local=chunk_local(self.device), chunk_count=chunks, **arguments,
        )  # fmt: skip

    def _upload(self, name: str, values: NDArray) -> Buffer:
        return self.device.upload(name, values, shape=(None, 3))

    def mark(self, positions: NDArray[np.float32]) -> None:
        """The cells of these vertices, (k, 3), are occupied."""
        self._launch(
            "cluster_cells_mark", len(positions), positions=self._upload("positions", positions),
            marks=self._marks, vertex_count=len(positions), **self.grid.arguments,
        )(Timeline())  # fmt: skip

    def marked(self) -> NDArray[np.uint8]:
        """A bit per cell, packed, to be put together by `|` with those of other batches."""
        assert self._marks is not None, "before `rank`"
        return np.packbits(self.device.read(self._marks))

    def rank(self) -> int:
        """Ranks of the occupied cells, and room for their sums; returns how many there are."""
        assert self._marks is not None, "once"
        device, words_count = self.device, self._word_count
        self._words = device.allocate("words", (words_count, 2), np.uint64)
        self._state = device.allocate("state", 4, np.uint32)
        sums = device.allocate("chunk_sums", chunk_count(device, words_count), np.uint32)
        counted = {"words": self._words, "chunk_sums": sums, "word_count": words_count}
        marks = self._marks.view((words_count, 8), np.uint64)
        self._launch("cluster_cells_count", words_count, marks=marks, **counted)(Timeline())
        self._launch("cluster_cells_rank", words_count, state=self._state, **counted)(Timeline())
        self.occupied = int(device.read(self._state)[0])
        self.capacity = max(self.occupied, 1)
        self._marks = None
        return self.occupied

    def _place(self, positions: NDArray[np.float32]) -> Buffer:
        count = len(positions)
        points = self.device.allocate("points", (count, 4), np.float32)
        self._launch(
            "cluster_cells_place", count, positions=self._upload("positions", positions), points=points,
            words=self._words, capacity=self.capacity, vertex_count=count, **self.grid.arguments,
        )(Timeline())  # fmt: skip
        return points

    def exponents(
        self, positions: NDArray[np.float32], triangles: NDArray[np.uint32]
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

    def scale(self, exponents: NDArray[np.float64]) -> None:
        """The fixed point of integer sums, from what `exponents` gave of all batches."""
        self._scale = fixed_point_scale(exponents, self.grid, self._triangles)

    def _room(self) -> Buffer:
        """The cluster map, cleared when it is first asked for."""
        if not hasattr(self, "_sums"):
            rows = (self.shares, self.capacity, 16) if self.private else (self.capacity, SUM_LANES)
            kind = np.float32 if self.private else np.int64
            self._sums = self.device.allocate("maps", rows, kind)
            self.device.fill(Timeline(), "pass_1", self._sums, 0)
        return self._sums

    def accumulate(
        self, positions: NDArray[np.float32], triangles: NDArray[np.uint32], map: int = 0
    ) -> NDArray[np.uint32]:
        """The batch's quadrics added to its cells; returns the triangles left, as ranks of cells, (s, 3), in order.

        Args:
            positions: (k, 3).
            triangles: (m, 3), rows of positions.
            map: the private map whose share they belong to.
        """
        count, sums = len(triangles), self._room()
        if not count:
            return np.zeros((0, 3), np.uint32)
        device = self.device
        read = {
            "points": self._place(positions), "triangles": self._upload("triangles", triangles),
            "triangle_count": count,
        }  # fmt: skip
        if self.private:
            left = device.allocate("pieces", 3 * count + 4, np.uint32)
            counts = device.allocate("piece_counts", 1, np.uint32)
            name = _PREFIX + "geometry_batch"
            self._owner[name].launch(
                name, 1, stage="batch", local=1, maps=sums, pieces=left, piece_counts=counts,
                map=map, capacity=self.capacity, **read,
            )(Timeline())  # fmt: skip
            return device.read(left, 3 * int(device.read(counts)[0])).reshape(-1, 3)
        name = _PREFIX + "geometry_fixed_point"
        self._owner[name].launch(
            name, count, stage="batch", sums=sums, scale=(*self._scale, 0), **read
        )(Timeline())
        left = device.allocate("survivors", (count, 3), np.uint32)
        counts = device.allocate("counts", 2, np.uint32)
        chunk_sums = device.allocate("chunk_sums", chunk_count(device, count), np.uint32)
        self._launch("cluster_emit_count", count, chunk_sums=chunk_sums, **read)(Timeline())
        self._launch(
            "cluster_emit_write", count, chunk_sums=chunk_sums, survivors=left, counts=counts,
            new_ranks=self._identity(), **read,
        )(Timeline())  # fmt: skip
        return device.read(left, int(device.read(counts)[1]))

    def look_for_borders(
        self, positions: NDArray[np.float32], triangles: NDArray[np.uint32]
    ) -> None:
        """Add the batch's edges to what `has_border` says in the end; vertices are told apart by where they lie."""
        x, y, z = (positions + np.float32(0)).view(np.uint32).T  # -0 is 0
        hashes = x * np.uint32(0x9E3779B1)
        for axis in (y, z):
            hashes = ((hashes ^ hashes >> np.uint32(15)) + axis) * np.uint32(0x2C1B3C6D)
        chunks = chunk_count(self.device, max(len(triangles), 1))
        sums = self.device.allocate("sums", (chunks, 2), np.uint32)
        self._launch(
            "cluster_borders_sum", max(len(triangles), 1), sums=sums,
            triangles=self._upload("triangles", hashes[triangles].reshape(-1, 3)),
            triangle_count=len(triangles),
        )(Timeline())  # fmt: skip
        self._edges += self.device.read(sums).sum(axis=0, dtype=np.uint32)

    @property
    def has_border(self) -> bool:
        """Is an edge of all batches used more often in one direction than in the other?"""
        return bool(self._edges.any())

    def _identity(self) -> Buffer:
        if not hasattr(self, "_same"):
            self._same = self.device.upload("ranks", np.arange(self.capacity, dtype=np.uint32))
        return self._same

    def sums(self) -> NDArray[np.int64]:
        """The integer sums, (capacity, 14), to be added to those of other batches."""
        return self.device.read(self._room())

    def solve(
        self, sums: NDArray[np.int64] | None = None
    ) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
        """The output's vertices (n, 3), from the origin, and each cell's, (capacity,), 0xFFFFFFFF where it has none.

        Args:
            sums: those of all batches, where they were added up elsewhere.
        """
        device, capacity = self.device, self.capacity
        held = self._room() if sums is None else device.upload("sums", sums, np.int64)
        solved = device.allocate("solved", (capacity, 4), np.float32)
        chunk_sums = device.allocate("chunk_sums", chunk_count(device, capacity), np.uint32)
        solve = {
            "state": self._state,
            "chunk_sums": chunk_sums,
            "capacity": capacity,
            "solved": solved,
        }
        limits = device.allocate("limits", 3, np.float32)  # of a warped grid alone
        own = {"maps": held, "map_count": self.shares}
        kernel = _PREFIX + "fragment_solve"
        if not self.private:
            own = {"sums": held, "inverse_scale": (*(1 / s for s in self._scale), 0)}
            kernel += "_fixed_point"
        self._launch(
            kernel, capacity, limits=limits, **solve, **own, **placing(self.grid, self.params)
        )(Timeline())
        grid = self.grid
        new_ranks = device.allocate("new_ranks", capacity, np.uint32)
        vertices = device.allocate("vertices", (capacity, 3), np.float32)
        counts = device.allocate("counts", 2, np.uint32)
        self._launch(
            "cluster_compact", capacity, new_ranks=new_ranks, vertices=vertices, counts=counts,
            low=(*grid.low, 0), to_model=(grid.unit, 1 / grid.prescale), **solve,
        )(Timeline())  # fmt: skip
        return device.read(vertices, int(device.read(counts)[0])), device.read(new_ranks)
