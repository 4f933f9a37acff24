"""Quadric vertex clustering on a device: upload, size, and the launches of a frame."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.cluster.quadric_clustering.judge import judge
from lodbench.kernels.cluster.quadric_clustering.reference import KINDS, simplify
from lodbench.kernels.cluster.quadric_clustering.upload import FOLDER, Upload
from lodbench.kernels.device import Device, DeviceError, Unsupported
from lodbench.kernels.program import Buffer, Launch
from lodbench.kernels.stages.scan import chunk_count, chunk_local
from lodbench.kernels.stages.timeline import Timeline
from lodbench.kernels.system import Check, DeviceSurface, Footprint, Frame, Traffic

if TYPE_CHECKING:
    from lodbench.kernels.cluster.quadric_clustering import Params

PLACEMENTS = {"robust": 0, "paper": 1, "average": 2}
SUM_LANES = 14
_PREFIX = "quadric_clustering_"

# launches that this device has compiled; a second subject need not run a frame to warm them
_warm: WeakKeyDictionary[Device, set[tuple[Any, ...]]] = WeakKeyDictionary()


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> QuadricClustering:
    """The mesh uploaded, and a frame ready to run.

    Raises:
        ValueError: more than 2**27 cells.
        Unsupported: no room, or no 64-bit atomics where fixed_point asks for them.
    """
    return QuadricClustering(Upload(device, mesh), params)


class QuadricClustering:
    """One mesh, one grid: `enqueue` leaves the simplified mesh in `output`."""

    def __init__(self, upload: Upload, params: Params) -> None:
        device = self._device = upload.device
        self._upload = upload
        self.params = params
        self.setup = upload.setup
        self._frame: list[Callable[[Timeline], Any]] = []
        self._ran = False
        before = device.used_bytes
        self.grid = Grid.over(upload.low, upload.high, params.cells)
        accumulate = params.accumulate
        if accumulate == "auto":
            accumulate = "private" if device.is_cpu else "fixed_point"
        self._private = accumulate == "private"
        self._fused = self._private and params.strategy == "fused"
        if not self._private and "cl_khr_int64_base_atomics" not in device.facts.extensions:
            raise Unsupported("needs cl_khr_int64_base_atomics, device has none")
        self._first = "pass_1_and_3" if self._fused else "pass_1"
        self._third = "pass_1_and_3" if self._fused else "pass_3"
        self._vertices = upload.mesh.vertex_count
        self._triangles = upload.mesh.triangle_count

        with self.setup.host("build"):
            names = ["vertex", "fragment", "geometry_emit"]
            names.append("geometry" if self._private else "geometry_fixed_point")
            names += ["geometry_duplicates"] * params.remove_duplicates
            self._programs = {name: device.build(f"{FOLDER}/{name}.cl") for name in names}
        with self.setup.host("size"):
            self._prepare_cells()
        self._prepare_sums()
        self._prepare_solve()
        self._prepare_triangles()
        self._scratch = device.used_bytes - before - self._output_bytes()
        key = (self._private, self._fused, params.remove_duplicates)
        warm = _warm.setdefault(device, set())
        self.setup.from_cache["first_launch"] = key in warm
        if key not in warm:
            with self.setup.host("first_launch"):
                self.enqueue(Frame(), Timeline())
                device.wait()
            warm.add(key)

    def _launch(self, kernel: str, rows: int, stage: str, **arguments: Any) -> Launch:
        """A launch of one item per chunk of `rows`."""
        chunks = chunk_count(self._device, rows)
        program = next(p for p in self._programs.values() if _PREFIX + kernel in p.kernels)
        return program.launch(
            _PREFIX + kernel, chunks, stage=stage, local=chunk_local(self._device),
            chunk_count=chunks, **arguments,
        )  # fmt: skip

    def _prepare_cells(self) -> None:
        """Which cells are occupied, and their ranks; run once here, since their number sizes the maps."""
        device, grid, stage = self._device, self.grid, self._first
        words_count = -(-grid.cell_count // 64)
        most = max(self._vertices, self._triangles, words_count)
        self._chunk_sums = device.allocate("chunk_sums", chunk_count(device, most), np.uint32)
        marks = device.allocate("marks", 64 * words_count, np.uint8)
        words = device.allocate("words", (words_count, 2), np.uint64)
        self._state = device.allocate("state", 4, np.uint32)
        place = {
            "positions": self._upload.positions,
            "vertex_count": self._vertices,
            **grid.arguments,
        }
        rank = {"words": words, "chunk_sums": self._chunk_sums, "word_count": words_count}
        self._frame += [
            lambda timeline: device.fill(timeline, stage, marks, 0),
            self._launch("vertex_mark", self._vertices, stage, marks=marks, **place),
            self._launch(
                "vertex_count", words_count, stage,
                marks=marks.view((words_count, 8), np.uint64), **rank,
            ),
            self._launch("vertex_rank", words_count, stage, state=self._state, **rank),
        ]  # fmt: skip
        for step in self._frame:
            step(Timeline())
        self.occupied = int(device.read(self._state)[0])
        self._capacity = max(self.occupied, 1)
        self._points = device.allocate("points", (self._vertices, 4), np.float32)
        self._frame.append(
            self._launch(
                "vertex_place", self._vertices, stage,
                words=words, points=self._points, capacity=self._capacity, **place,
            )
        )  # fmt: skip

    def _prepare_sums(self) -> None:
        """The cluster map and the walk over the triangles that fills it."""
        device, chunks, capacity = self._device, self.params.chunks, self._capacity
        stage = self._first
        arguments: dict[str, Any] = {
            "points": self._points,
            "triangles": self._upload.triangles,
            "triangle_count": self._triangles,
        }
        if self._private:
            self._sums = device.allocate("maps", (chunks, capacity, 16), np.float32)
            arguments |= {"maps": self._sums, "map_count": chunks, "capacity": capacity}
            if self._fused:
                room = 3 * self._triangles + 4 * chunks
                self._pieces = device.allocate("pieces", room, np.uint32)
                self._piece_counts = device.allocate("piece_counts", chunks, np.uint32)
                arguments |= {"pieces": self._pieces, "piece_counts": self._piece_counts}
            name = "geometry_fused" if self._fused else "geometry_accumulate"
            self._frame.append(
                self._programs["geometry"].launch(
                    _PREFIX + name, chunks, stage=self._first, local=1, **arguments
                )
            )
        else:
            sums = self._sums = device.allocate("sums", (capacity, SUM_LANES), np.int64)
            self._scale = self._fixed_point_scale()
            self._frame += [
                lambda timeline: device.fill(timeline, stage, sums, 0),
                self._programs["geometry_fixed_point"].launch(
                    _PREFIX + "geometry_fixed_point", self._triangles, stage=self._first,
                    sums=sums, scale=(*self._scale, 0), **arguments,
                ),
            ]  # fmt: skip

    def _fixed_point_scale(self) -> tuple[float, float, float]:
        """Powers of two for A, b and positions, as large as sums of all triangles in one cell allow.

        The bound comes from counts of triangles by exponent, which no order of the triangles changes.
        """
        device, triangles = self._device, max(self._triangles, 1)
        self._frame[-1](Timeline())
        chunks = chunk_count(device, triangles)
        exponents = device.allocate("exponents", (chunks, 256), np.uint32)
        program = device.build(f"{FOLDER}/setup.cl")
        program.launch(
            "quadric_clustering_setup_exponents", chunks, stage="size", local=chunk_local(device),
            points=self._points, triangles=self._upload.triangles, exponents=exponents,
            triangle_count=self._triangles, chunk_count=chunks,
        )(Timeline())  # fmt: skip
        counts = device.read(exponents).sum(0, dtype=np.float64)
        area = 3 * float(counts @ np.exp2(np.arange(256) - 126.0))
        reach = 2 * max(self.grid.extent, 1.0)  # no corner is farther than sqrt(3) extents
        bounds = (area, area * reach, 3 * triangles * reach)
        exponent = [np.clip(62 - np.ceil(np.log2(max(b, 1e-30))), -100, 100) for b in bounds]
        scale_a, scale_b, scale_p = (float(2.0**e) for e in exponent)
        return scale_a, scale_b, scale_p

    def _prepare_solve(self) -> None:
        """Pass 2: representatives of all occupied cells, then the used ones moved together."""
        device, capacity, grid = self._device, self._capacity, self.grid
        self._solved = device.allocate("solved", (capacity, 4), np.float32)
        self._new_ranks = device.allocate("new_ranks", capacity, np.uint32)
        self._vertices_out = device.allocate("vertices", (capacity, 3), np.float32)
        self._counts = device.allocate("counts", 2, np.uint32)
        shared: dict[str, Any] = {
            "state": self._state,
            "chunk_sums": self._chunk_sums,
            "capacity": capacity,
        }
        solve = shared | {
            "solved": self._solved,
            "per_box": 1 / grid.extent if grid.extent else 1.0,
            "placement": PLACEMENTS[self.params.placement],
        }
        if self._private:
            solve |= {"maps": self._sums, "map_count": self.params.chunks}
        else:
            solve |= {"sums": self._sums, "inverse_scale": (*(1 / s for s in self._scale), 0)}
        kernel = "fragment_solve" if self._private else "fragment_solve_fixed_point"
        self._frame += [
            self._launch(kernel, capacity, "pass_2", **solve),
            self._launch(
                "fragment_compact", capacity, "pass_2",
                solved=self._solved, new_ranks=self._new_ranks, vertices=self._vertices_out,
                counts=self._counts, low=(*grid.low, 0),
                to_model=(grid.unit, 1 / grid.prescale), **shared,
            ),
        ]  # fmt: skip

    def _prepare_triangles(self) -> None:
        """Pass 3: the surviving triangles with the numbers of their output vertices."""
        device, stage, count = self._device, self._third, self._triangles
        self._survivors = device.allocate("survivors", (count, 3), np.uint32)
        joined, joined_counts = self._survivors, self._counts
        if self.params.remove_duplicates:
            joined = device.allocate("joined", (count, 3), np.uint32)
        written = {"new_ranks": self._new_ranks, "survivors": joined, "counts": joined_counts}
        if self._fused:
            self._frame.append(
                self._launch(
                    "geometry_emit_join", count, stage,
                    pieces=self._pieces, piece_counts=self._piece_counts,
                    map_count=self.params.chunks, triangle_count=count, **written,
                )
            )  # fmt: skip
        else:
            read = {
                "points": self._points,
                "triangles": self._upload.triangles,
                "chunk_sums": self._chunk_sums,
                "triangle_count": count,
            }
            self._frame += [
                self._launch("geometry_emit_count", count, stage, **read),
                self._launch("geometry_emit_write", count, stage, **read, **written),
            ]
        if self.params.remove_duplicates:
            self._prepare_duplicates(joined, stage)

    def _prepare_duplicates(self, joined: Buffer, stage: str) -> None:
        device, count, total = self._device, self._triangles, self._counts
        slot_count = 2 << max(count, 1).bit_length()
        slots = device.allocate("slots", slot_count, np.uint32)
        flags = device.allocate("flags", count, np.uint8)
        self._counts = device.allocate("counts", 2, np.uint32)
        found = {"joined": joined, "total": total, "slots": slots, "slot_mask": slot_count - 1}
        kept = {"flags": flags, "chunk_sums": self._chunk_sums}
        self._frame += [
            lambda timeline: device.fill(timeline, stage, slots, 0xFFFFFFFF),
            self._launch("geometry_duplicates_insert", count, stage, **found),
            self._launch("geometry_duplicates_count", count, stage, **found, **kept),
            self._launch(
                "geometry_duplicates_write", count, stage,
                joined=joined, total=total, survivors=self._survivors, counts=self._counts, **kept,
            ),
        ]  # fmt: skip

    @property
    def output(self) -> DeviceSurface:
        """The last frame's mesh; as many vertices as occupied cells and triangles as the input at most."""
        return DeviceSurface(
            positions=self._vertices_out,
            normals=None,
            triangles=self._survivors,
            vertex_count=self._capacity,
            triangle_count=self._triangles,
            counts=self._counts,
        )

    def enqueue(self, frame: Frame, timeline: Timeline) -> None:
        """All passes; never waits. The input is the same each frame."""
        self._ran = True
        for step in self._frame:
            step(timeline)

    def _live(self) -> tuple[int, int]:
        """Output vertices and triangles of the last frame; one is run when there was none."""
        if not self._ran:
            self.enqueue(Frame(), Timeline())
        occupied = int(self._device.read(self._state)[0])
        if occupied > self._capacity:
            raise DeviceError(
                f"cells: expected {self._capacity} occupied as in set-up, got {occupied}"
            )
        vertices, triangles = self._device.read(self._counts)
        return int(vertices), int(triangles)

    def result(self) -> Sequence[TriangleMesh]:
        """The simplified mesh, without normals."""
        vertices, triangles = self._live()
        return [
            TriangleMesh(
                self._device.read(self._vertices_out, vertices),
                self._device.read(self._survivors, triangles),
            )
        ]

    def vertex_map(self) -> NDArray[np.uint32]:
        """The last frame's output vertex of each input vertex, (n,); 0xFFFFFFFF where its cell has none."""
        result = self._device.allocate("vertex_map", self._vertices, np.uint32)
        self._launch(
            "vertex_map", self._vertices, "vertex_map",
            points=self._points, new_ranks=self._new_ranks, vertex_map=result,
            vertex_count=self._vertices,
        )(Timeline())  # fmt: skip
        return self._device.read(result)

    def check(self) -> Check:
        """Same triangles as the reference, and each representative as deep in its planes, in cells."""
        return judge(self.result()[0], simplify(self._upload.mesh, self.params))

    def counters(self) -> Mapping[str, int | float]:
        """Sizes in and out, occupied cells, and how the used cells' representatives were placed."""
        vertices, triangles = self._live()
        solved = self._device.read(self._solved, self.occupied)[:, 3]
        placed = np.bincount(solved.astype(np.int64), minlength=len(KINDS) + 1)[1:]
        return {
            "vertices": vertices,
            "triangles": triangles,
            "vertices_in": self._vertices,
            "triangles_in": self._triangles,
            "cells": self.grid.cell_count,
            "cells_occupied": self.occupied,
            **{f"placed_{kind}": int(n) for kind, n in zip(KINDS, placed, strict=True)},
        }

    def _output_bytes(self) -> int:
        return self._vertices_out.size_bytes + self._survivors.size_bytes + self._counts.size_bytes

    def footprint(self) -> Footprint:
        """Input, room for the output, and everything between."""
        vertices, triangles = self._live()
        size = 12 * (vertices + triangles)
        return Footprint(
            input_bytes=self._upload.positions.size_bytes + self._upload.triangles.size_bytes,
            output_bytes=self._output_bytes(),
            scratch_bytes=self._scratch,
            stored_vertices=vertices,
            stored_bytes=size,
            static_vertices=vertices,
            static_bytes=size,
        )

    def traffic(self) -> Mapping[str, Traffic]:
        """Input and output once, the points written once and read once, each map written and read once."""
        vertices, triangles = self._live()
        lanes = self._sums.size_bytes
        out = 12 * triangles
        first = 12 * self._vertices + 12 * self._triangles + 32 * self._vertices + lanes
        # 70 for a plane and its products, 14 sums at each of 3 corners; a solve is about 90
        flops = 112 * self._triangles
        if self._fused:
            first += out
        stages = {
            self._first: Traffic(first, flops),
            "pass_2": Traffic(lanes + 12 * vertices, 90 * self.occupied),
        }
        if not self._fused:
            stages["pass_3"] = Traffic(12 * self._triangles + 4 * self._vertices + out)
        return stages
