"""The three passes of quadric vertex clustering: their memory and their launches, in the order of a frame."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.cluster.quadric_clustering.params import Params
from lodbench.kernels.cluster.quadric_clustering.upload import FOLDER, Upload
from lodbench.kernels.device import Unsupported
from lodbench.kernels.program import Buffer, Launch, Program
from lodbench.kernels.stages.scan import chunk_count, chunk_local
from lodbench.kernels.stages.timeline import Timeline

PLACEMENTS = {"robust": 0, "paper": 1, "average": 2}
SUM_LANES = 14
_PREFIX = "quadric_clustering_"


class Passes:
    """What a frame enqueues, `steps`, and the buffers that it fills.

    ```
    state         uint  [4]               [0]: occupied cells
    points        float [4 * vertices]    x y z in units of the largest cell edge, bits of the cell's rank
    sums          float [chunks, capacity, 16] or long [capacity, 14]   the cluster map
    solved        float [4 * capacity]    representative in those units, kind
    new_ranks     uint  [capacity]        output vertex of a cell
    vertices_out  float [3 * capacity]    output positions
    survivors     uint  [3 * triangles]   output triangles
    counts        uint  [2]               live output vertices and triangles
    ```

    Attributes:
        private: one float map per chunk, else one of integers.
        fused: passes 1 and 3 in one walk.
        first, third: the stage names of passes 1 and 3.
        occupied: cells with a vertex; the input is the same each frame, so this is known once it has been counted.
        capacity: rows of the cluster map, at least 1.
    """

    def __init__(self, upload: Upload, grid: Grid, params: Params) -> None:
        device = self._device = upload.device
        self._upload, self._grid, self._params = upload, grid, params
        self._vertices = upload.mesh.vertex_count
        self._triangles = upload.mesh.triangle_count
        accumulate = params.accumulate
        if accumulate == "auto":
            accumulate = "private" if device.is_cpu else "fixed_point"
        self.private = accumulate == "private"
        self.fused = self.private and params.strategy == "fused"
        if not self.private and "cl_khr_int64_base_atomics" not in device.facts.extensions:
            raise Unsupported("needs cl_khr_int64_base_atomics, device has none")
        self.first = "pass_1_and_3" if self.fused else "pass_1"
        self.third = "pass_1_and_3" if self.fused else "pass_3"
        with upload.setup.host("build"):
            names = ["geometry_fixed_point"] * (not self.private)
            names += ["geometry_duplicates"] * params.remove_duplicates
            extra = [device.build(f"{FOLDER}/{name}.cl") for name in names]
            self._programs = [upload.program, *extra]
        self.steps: list[Callable[[Timeline], Any]] = []
        with upload.setup.host("size"):
            self._prepare_cells()
        self._prepare_sums()
        self._prepare_solve()
        self._prepare_triangles()

    def launch(self, kernel: str, rows: int, stage: str, **arguments: Any) -> Launch:
        """A launch of one item per chunk of `rows`."""
        chunks = chunk_count(self._device, rows)
        return self._program(kernel).launch(
            _PREFIX + kernel, chunks, stage=stage, local=chunk_local(self._device),
            chunk_count=chunks, **arguments,
        )  # fmt: skip

    def _program(self, kernel: str) -> Program:
        return next(p for p in self._programs if _PREFIX + kernel in p.kernels)

    def _prepare_cells(self) -> None:
        """Which cells are occupied, and their ranks; run once here, since their number sizes the maps."""
        device, grid, stage = self._device, self._grid, self.first
        words_count = -(-grid.cell_count // 64)
        most = max(self._vertices, self._triangles, words_count)
        self._chunk_sums = device.allocate("chunk_sums", chunk_count(device, most), np.uint32)
        marks = device.allocate("marks", 64 * words_count, np.uint8)
        words = device.allocate("words", (words_count, 2), np.uint64)
        self.state = device.allocate("state", 4, np.uint32)
        place = {
            "positions": self._upload.positions,
            "vertex_count": self._vertices,
            **grid.arguments,
        }
        rank = {"words": words, "chunk_sums": self._chunk_sums, "word_count": words_count}
        self.steps += [
            lambda timeline: device.fill(timeline, stage, marks, 0),
            self.launch("vertex_mark", self._vertices, stage, marks=marks, **place),
            self.launch(
                "vertex_count", words_count, stage,
                marks=marks.view((words_count, 8), np.uint64), **rank,
            ),
            self.launch("vertex_rank", words_count, stage, state=self.state, **rank),
        ]  # fmt: skip
        for step in self.steps:
            step(Timeline())
        self.occupied = int(device.read(self.state)[0])
        self.capacity = max(self.occupied, 1)
        self.points = device.allocate("points", (self._vertices, 4), np.float32)
        self.steps.append(
            self.launch(
                "vertex_place", self._vertices, stage,
                words=words, points=self.points, capacity=self.capacity, **place,
            )
        )  # fmt: skip

    def _prepare_sums(self) -> None:
        """The cluster map and the walk over the triangles that fills it."""
        device, chunks, capacity = self._device, self._params.chunks, self.capacity
        stage = self.first
        arguments: dict[str, Any] = {
            "points": self.points,
            "triangles": self._upload.triangles,
            "triangle_count": self._triangles,
        }
        if self.private:
            self.sums = device.allocate("maps", (chunks, capacity, 16), np.float32)
            arguments |= {"maps": self.sums, "map_count": chunks, "capacity": capacity}
            if self.fused:
                room = 3 * self._triangles + 4 * chunks
                self._pieces = device.allocate("pieces", room, np.uint32)
                self._piece_counts = device.allocate("piece_counts", chunks, np.uint32)
                arguments |= {"pieces": self._pieces, "piece_counts": self._piece_counts}
            name = "geometry_fused" if self.fused else "geometry_accumulate"
            self.steps.append(
                self._program(name).launch(
                    _PREFIX + name, chunks, stage=self.first, local=1, **arguments
                )
            )
        else:
            sums = self.sums = device.allocate("sums", (capacity, SUM_LANES), np.int64)
            self._scale = self._fixed_point_scale()
            self.steps += [
                lambda timeline: device.fill(timeline, stage, sums, 0),
                self._program("geometry_fixed_point").launch(
                    _PREFIX + "geometry_fixed_point", self._triangles, stage=self.first,
                    sums=sums, scale=(*self._scale, 0), **arguments,
                ),
            ]  # fmt: skip

    def _fixed_point_scale(self) -> tuple[float, float, float]:
        """Powers of two for A, b and positions, as large as sums of all triangles in one cell allow.

        The bound comes from counts of triangles by exponent, which no order of the triangles changes.
        """
        device, triangles = self._device, max(self._triangles, 1)
        self.steps[-1](Timeline())
        chunks = chunk_count(device, triangles)
        exponents = device.allocate("exponents", (chunks, 256), np.uint32)
        self._upload.program.launch(
            "quadric_clustering_setup_exponents", chunks, stage="size", local=chunk_local(device),
            points=self.points, triangles=self._upload.triangles, exponents=exponents,
            triangle_count=self._triangles, chunk_count=chunks,
        )(Timeline())  # fmt: skip
        counts = device.read(exponents).sum(0, dtype=np.float64)
        area = 3 * float(counts @ np.exp2(np.arange(256) - 126.0))
        reach = 2 * max(self._grid.extent, 1.0)  # no corner is farther than sqrt(3) extents
        bounds = (area, area * reach, 3 * triangles * reach)
        exponent = [np.clip(62 - np.ceil(np.log2(max(b, 1e-30))), -100, 100) for b in bounds]
        scale_a, scale_b, scale_p = (float(2.0**e) for e in exponent)
        return scale_a, scale_b, scale_p

    def _prepare_solve(self) -> None:
        """Pass 2: representatives of all occupied cells, then the used ones moved together."""
        device, capacity, grid = self._device, self.capacity, self._grid
        self.solved = device.allocate("solved", (capacity, 4), np.float32)
        self.new_ranks = device.allocate("new_ranks", capacity, np.uint32)
        self.vertices_out = device.allocate("vertices", (capacity, 3), np.float32)
        self.counts = device.allocate("counts", 2, np.uint32)
        shared: dict[str, Any] = {
            "state": self.state,
            "chunk_sums": self._chunk_sums,
            "capacity": capacity,
        }
        solve = shared | {
            "solved": self.solved,
            "per_box": 1 / grid.extent if grid.extent else 1.0,
            "placement": PLACEMENTS[self._params.placement],
        }
        if self.private:
            solve |= {"maps": self.sums, "map_count": self._params.chunks}
        else:
            solve |= {"sums": self.sums, "inverse_scale": (*(1 / s for s in self._scale), 0)}
        kernel = "fragment_solve" if self.private else "fragment_solve_fixed_point"
        self.steps += [
            self.launch(kernel, capacity, "pass_2", **solve),
            self.launch(
                "fragment_compact", capacity, "pass_2",
                solved=self.solved, new_ranks=self.new_ranks, vertices=self.vertices_out,
                counts=self.counts, low=(*grid.low, 0),
                to_model=(grid.unit, 1 / grid.prescale), **shared,
            ),
        ]  # fmt: skip

    def _prepare_triangles(self) -> None:
        """Pass 3: the surviving triangles with the numbers of their output vertices."""
        device, stage, count = self._device, self.third, self._triangles
        self.survivors = device.allocate("survivors", (count, 3), np.uint32)
        joined, joined_counts = self.survivors, self.counts
        if self._params.remove_duplicates:
            joined = device.allocate("joined", (count, 3), np.uint32)
        written = {"new_ranks": self.new_ranks, "survivors": joined, "counts": joined_counts}
        if self.fused:
            self.steps.append(
                self.launch(
                    "geometry_emit_join", count, stage,
                    pieces=self._pieces, piece_counts=self._piece_counts,
                    map_count=self._params.chunks, triangle_count=count, **written,
                )
            )  # fmt: skip
        else:
            read = {
                "points": self.points,
                "triangles": self._upload.triangles,
                "chunk_sums": self._chunk_sums,
                "triangle_count": count,
            }
            self.steps += [
                self.launch("geometry_emit_count", count, stage, **read),
                self.launch("geometry_emit_write", count, stage, **read, **written),
            ]
        if self._params.remove_duplicates:
            self._prepare_duplicates(joined, stage)

    def _prepare_duplicates(self, joined: Buffer, stage: str) -> None:
        device, count, total = self._device, self._triangles, self.counts
        slot_count = 2 << max(count, 1).bit_length()
        slots = device.allocate("slots", slot_count, np.uint32)
        flags = device.allocate("flags", count, np.uint8)
        self.counts = device.allocate("counts", 2, np.uint32)
        found = {"joined": joined, "total": total, "slots": slots, "slot_mask": slot_count - 1}
        kept = {"flags": flags, "chunk_sums": self._chunk_sums}
        self.steps += [
            lambda timeline: device.fill(timeline, stage, slots, 0xFFFFFFFF),
            self.launch("geometry_duplicates_insert", count, stage, **found),
            self.launch("geometry_duplicates_count", count, stage, **found, **kept),
            self.launch(
                "geometry_duplicates_write", count, stage,
                joined=joined, total=total, survivors=self.survivors, counts=self.counts, **kept,
            ),
        ]  # fmt: skip
