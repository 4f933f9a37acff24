"""Clustering of a mesh that comes in batches: its occupied cells, the triangles left, and what becomes of the cells.

The passes are those of `clustering.py`, over the same kernels; a system adds up what it wants per cell.

Source: Lindstrom 2000, Out-of-Core Simplification of Large Polygonal Models; the batches are ours.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.batches import MeshFile, unit
from lodbench.kernels.cluster import borders_stream
from lodbench.kernels.cluster.borders import NO_VERTICES
from lodbench.kernels.cluster.borders_stream import StreamBorders
from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.cluster.turned import NO_VERTEX
from lodbench.kernels.cluster.upload import SHARED
from lodbench.kernels.opencl import Buffer, Device, Launch, Program, Timeline
from lodbench.kernels.stages.scan import chunk_count, chunk_local

ATTRIBUTES = "cluster/attributes_batch.cl"
Tell = Callable[[str, float], None]
"""(pass, share of it that is done)"""


class CellBatches:
    """The cells of one grid; call in this order, each for all batches: `mark`, `rank`, what adds up, `solve`.

    Attributes:
        grid: the grid.
        occupied: cells with a vertex, known from `rank` on.
        capacity: rows of what is kept per cell, at least 1; those of kept vertices come last.
        kept: vertices that stay by themselves, by their rows in the file, ascending.
    """

    FILES: Sequence[str] = ()
    SHARED_ONLY = False  # must triangles share vertices, since each vertex counts once?

    def __init__(
        self,
        device: Device,
        grid: Grid,
        params: Any,
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
            Unsupported: no room, or something that the device lacks.
        """
        self.device, self.grid, self.params = device, grid, params
        self.kept = NO_VERTICES
        self._carried: dict[str, Buffer] = {}
        self._triangles = triangle_count
        self._programs: list[Program] = [device.build(*self.FILES, *SHARED)]
        self._word_count = -(-grid.cell_count // 64)
        if marked is None:
            self._marks: Buffer | None = device.allocate("marks", 64 * self._word_count, np.uint8)
            device.fill(Timeline(), "pass_1", self._marks, 0)
        else:
            self._marks = device.upload("marks", np.unpackbits(marked), np.uint8)

    @staticmethod
    def weights(device: Device, params: Any) -> dict[str, float]:
        """The passes of `walk`, and about how long they take: one over the vertices alone is 1."""
        raise NotImplementedError

    def walk(
        self,
        source: MeshFile,
        rows: int,
        borders: StreamBorders | None,
        spill: BinaryIO,
        tell: Tell,
    ) -> int:
        """All that adds up, over the file; triangles left go to `spill` as ranks of cells, and are counted."""
        raise NotImplementedError

    def solved(self) -> tuple[Buffer, Buffer]:
        """Of each cell its representative, float (capacity, 4) as `Clustering` has it; `chunk_sums` of used cells."""
        raise NotImplementedError

    def kernel(self, name: str) -> Any:
        """The kernel of this name."""
        return next(program for program in self._programs if name in program.kernels)

    def _launch(self, kernel: str, rows: int, **arguments: Any) -> Launch:
        """A launch of one item per chunk of `rows`."""
        chunks = chunk_count(self.device, rows)
        return self.kernel(kernel).launch(
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

    def rank(self, kept: NDArray[np.uint32] = NO_VERTICES) -> int:
        """Ranks of the occupied cells, and room for their sums; returns how many there are.

        Args:
            kept: see the class.
        """
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
        self._marks = None
        self.kept = kept
        if len(kept):
            self._programs.append(device.build(borders_stream.FILE))
            state = np.array([self.occupied + len(kept), 0, 0, 0], np.uint32)
            self._state = device.upload("state", state)
        self.capacity = max(self.occupied + len(kept), 1)
        return self.occupied

    def _place(
        self, positions: NDArray[np.float32], vertices: NDArray[np.integer] | int = 0
    ) -> Buffer:
        """Vertices in units with their ranks; `vertices` as a `Batch` has them."""
        count = len(positions)
        points = self.device.allocate("points", (count, 4), np.float32)
        self._launch(
            "cluster_cells_place", count, positions=self._upload("positions", positions), points=points,
            words=self._words, capacity=self.capacity, vertex_count=count, **self.grid.arguments,
        )(Timeline())  # fmt: skip
        rows, numbers = kept_of(self.kept, vertices, count)
        if len(rows):
            self._launch(
                "cluster_borders_batch_keep", len(rows), kept_rows=self.device.upload("kept_rows", rows),
                ranks=self.device.upload("ranks", numbers + np.uint32(self.occupied)),
                points=points, kept_count=len(rows),
            )(Timeline())  # fmt: skip
        return points

    def _left(self, points: Buffer, triangles: Buffer) -> NDArray[np.uint32]:
        """The triangles left of a batch, as ranks of cells, (s, 3), in order."""
        device, count = self.device, triangles.shape[0]
        left = device.allocate("survivors", (count, 3), np.uint32)
        counts = device.allocate("counts", 2, np.uint32)
        read = {
            "points": points, "triangles": triangles, "triangle_count": count,
            "chunk_sums": device.allocate("chunk_sums", chunk_count(device, count), np.uint32),
        }  # fmt: skip
        self._launch("cluster_emit_count", count, **read)(Timeline())
        self._launch(
            "cluster_emit_write", count, survivors=left, counts=counts,
            new_ranks=self._identity(), **read,
        )(Timeline())  # fmt: skip
        return device.read(left, int(device.read(counts)[1]))

    def _carry(
        self, points: Buffer, triangles: Buffer, values: Mapping[str, NDArray[np.float32]]
    ) -> None:
        """A batch's attributes added to its cells."""
        if values and not self._carried:
            self._programs.append(self.device.build(ATTRIBUTES))
        for name, own in values.items():
            if name not in self._carried:
                sums = self.device.allocate(name, (self.capacity, 8), np.float32)
                self.device.fill(Timeline(), "attributes", sums, 0)
                self._carried[name] = sums
            kernel = "cluster_attributes_batch_add"
            self.kernel(kernel).launch(
                kernel, 1, stage="attributes", local=1, points=points, triangles=triangles,
                values=self._upload("values", own), sums=self._carried[name],
                triangle_count=triangles.shape[0],
            )(Timeline())  # fmt: skip

    def attributes(self, new_ranks: NDArray[np.uint32]) -> dict[str, NDArray[np.float32]]:
        """Of each output vertex the mean over its cell, (n, 3) by name; `new_ranks` as `solve` gives them."""
        there = new_ranks != NO_VERTEX
        found = {}
        for name, sums in self._carried.items():
            totals = self.device.read(sums)[there]
            if name == "normals":
                found[name] = unit(totals[:, :3])
            else:
                found[name] = totals[:, :3] / np.maximum(totals[:, 3:4], np.float32(1e-30))
        return found

    def _identity(self) -> Buffer:
        if not hasattr(self, "_same"):
            self._same = self.device.upload("ranks", np.arange(self.capacity, dtype=np.uint32))
        return self._same

    def solve(
        self, source: MeshFile | None = None
    ) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
        """The output's vertices (n, 3), from the origin, and each cell's, (capacity,), 0xFFFFFFFF where it has none.

        Args:
            source: where vertices are kept, the file, which has their positions.
        """
        device, capacity, grid = self.device, self.capacity, self.grid
        solved, chunk_sums = self.solved()
        new_ranks = device.allocate("new_ranks", capacity, np.uint32)
        vertices = device.allocate("vertices", (capacity, 3), np.float32)
        counts = device.allocate("counts", 2, np.uint32)
        self._launch(
            "cluster_compact", capacity, new_ranks=new_ranks, vertices=vertices, counts=counts,
            low=(*grid.low, 0), to_model=(grid.unit, 1 / grid.prescale), solved=solved,
            state=self._state, chunk_sums=chunk_sums, capacity=capacity,
        )(Timeline())  # fmt: skip
        numbers = device.read(new_ranks)
        found = device.read(vertices, int(device.read(counts)[0]))
        if len(self.kept):
            assert source is not None
            own = numbers[self.occupied :]
            there = own != NO_VERTEX
            found[own[there]] = source.at(self.kept[there])
        return found, numbers


def kept_of(
    kept: NDArray[np.uint32], vertices: NDArray[np.integer] | int, count: int
) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
    """Which of a batch's `count` rows are kept vertices, and their numbers among those."""
    if not len(kept):
        return NO_VERTICES, NO_VERTICES
    if isinstance(vertices, int):
        low, high = np.searchsorted(kept, (vertices, vertices + count))
        rows = (kept[low:high] - np.uint32(vertices)).astype(np.uint32)
        return rows, np.arange(low, high, dtype=np.uint32)
    numbers = np.minimum(np.searchsorted(kept, vertices), len(kept) - 1)
    rows = np.flatnonzero(kept[numbers] == vertices)
    return rows.astype(np.uint32), numbers[rows].astype(np.uint32)
