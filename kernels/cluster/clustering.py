"""What every clustering on a grid shares: occupied cells, output vertices and triangles, and the map to them.

Long because a frame's steps are read in their order.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster import turned
from lodbench.kernels.cluster.borders import NO_EDGES, NO_VERTICES, border_vertices
from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.cluster.mapped import Mapped
from lodbench.kernels.cluster.search import Found
from lodbench.kernels.cluster.target import ClusterTarget
from lodbench.kernels.cluster.upload import Upload
from lodbench.kernels.cluster.warp import Warp
from lodbench.kernels.opencl import Buffer, Device, DeviceError, Launch, Program, Timeline
from lodbench.kernels.stages.scan import chunk_count, chunk_local
from lodbench.kernels.subject import POINT, WORD, Step
from lodbench.kernels.system import DeviceSurface, Frame
from lodbench.kernels.targets import missed

FEW_WORDS = 8192  # of cells: one core numbers them sooner than two launches are under way

# launches that this device has compiled; a second subject need not run a frame to warm them
_warm: WeakKeyDictionary[Device, set[tuple[Any, ...]]] = WeakKeyDictionary()


class Clustering(Mapped):
    """One mesh, one grid; the input is the same each frame.

    A system's set-up calls, in this order, `find_cells`, what fills `solved` and `chunk_sums` from `points`, then
    `compact`, `emit` and `ready`.

    ```
    words         ulong [2 * words]       of 64 cells each: their bits, occupied cells before them
    state         uint  [4]               [0]: occupied cells
    points        float [4 * vertices]    x y z in units of the largest even cell edge, bits of the cell's rank
    solved        float [4 * capacity]    representative in those units, kind; kind 0: no surviving triangle uses it
    chunk_sums    uint  [chunks]          used cells of each chunk of cells
    new_ranks     uint  [capacity]        output vertex of a cell
    vertices_out  float [3 * capacity]    output positions
    survivors     uint  [3 * triangles]   output triangles
    counts        uint  [2]               live output vertices and triangles
    limits        float [3 * capacity]    under a warp: the longest steps along x, y, z, in the same units
    ```

    Attributes:
        given: the mesh on the device, positions and triangles.
        grid: the even grid over the mesh: all lengths are in its units.
        cell_grid: the grid that the cells are those of: over the warped mesh where there is a warp, else the same.
        occupied: cells with a vertex, known once they have been counted.
        capacity: rows of what is kept per cell, at least 1.
        found: how a search got to the grid.
        border: border edges, (k, 3) uint32 as `border_edges` has them, where they are of use.
        kept: border vertices that stay by themselves; they have the ranks after those of the cells.
    """

    def __init__(self, upload: Upload, params: ClusterTarget, found: Found | None) -> None:
        super().__init__(upload.device, upload.setup)
        self.params, self.found = params, found
        self.given = self.hold("input", upload.positions, upload.triangles)
        self._mesh, self._upload = upload.mesh, upload
        self._vertices, self._triangles = upload.mesh.vertex_count, upload.mesh.triangle_count
        self._programs: list[Program] = [upload.program]
        self.cell_grid = Grid.over(*upload.box, params.grid_cells)
        self.grid = self.cell_grid
        if upload.warp is not None:
            self.grid = upload.warp.even(params.grid_cells)
        self.border, self.kept, self._found = NO_EDGES, NO_VERTICES, 0
        if params.uses_border:
            self.border = upload.border_edges
            self.kept = border_vertices(self.border) if params.keeps_border else NO_VERTICES

    def launch(self, kernel: str, rows: int, stage: str, **arguments: Any) -> Launch:
        """A launch of one item per chunk of `rows`."""
        chunks = chunk_count(self.device, rows)
        return self.program(kernel).launch(
            kernel, chunks, stage=stage, local=chunk_local(self.device),
            chunk_count=chunks, **arguments,
        )  # fmt: skip

    def program(self, kernel: str) -> Program:
        """The one that has this kernel."""
        return next(p for p in self._programs if kernel in p.kernels)

    def find_cells(self, stage: str) -> None:
        """Which cells are occupied, and their ranks; run once here, since their number sizes what comes after."""
        grid, upload = self.cell_grid, self._upload
        words_count = -(-grid.cell_count // 64)
        most = max(self._vertices, self._triangles, words_count)
        chunks = chunk_count(self.device, most)
        self.chunk_sums = self.allocate("chunk_sums", chunks, np.uint32)
        marks = self.allocate("marks", 64 * words_count, np.uint8)
        words = self.words = self.allocate("words", (words_count, 2), np.uint64)
        self.state = self.allocate("state", 4, np.uint32)
        place = {
            "positions": upload.placed,
            "vertex_count": self._vertices,
            **grid.arguments,
        }
        rank = {"words": words, "chunk_sums": self.chunk_sums, "word_count": words_count}
        eights = marks.view((words_count, 8), np.uint64)
        if upload.warping is not None:
            self.hold("scratch", upload.placed, upload.stretch)
            upload.warping.stage = stage
            self.add(upload.warping, bytes=3 * POINT * self._vertices)
        self.fill(stage, marks, 0)
        self.add(self.launch("cluster_cells_mark", self._vertices, stage, marks=marks, **place))
        if self.device.is_cpu and words_count <= FEW_WORDS:
            name = "cluster_cells_number"
            self.add(
                self.program(name).launch(
                    name, 1, stage=stage, local=1, marks=eights, state=self.state, **rank
                )
            )
        else:
            self.add(self.launch("cluster_cells_count", words_count, stage, marks=eights, **rank))
            self.add(
                self.launch("cluster_cells_rank", words_count, stage, state=self.state, **rank)
            )
        for step in self._steps:
            step.enqueue(Timeline())
        self._found = len(self._steps)
        self.occupied = int(self.device.read(self.state)[0])
        self.capacity = max(self.occupied + len(self.kept), 1)
        self.points = self.allocate("points", (self._vertices, 4), np.float32)
        self.add(
            self.launch(
                "cluster_cells_place", self._vertices, stage,
                words=words, points=self.points, capacity=self.capacity, **place,
            ),
            bytes=POINT * self._vertices + self.points.size_bytes,
        )  # fmt: skip
        self.limits = self.allocate("limits", (self.capacity if upload.warp else 1, 3), np.float32)
        if upload.warp is not None:
            self._unwarp(upload, upload.warp, stage)
        self.solved = self.allocate("solved", (self.capacity, 4), np.float32)
        if len(self.kept):
            kept = self.upload("kept", self.kept, np.uint32)
            self._kept = {"kept": kept, "occupied": self.occupied, "kept_count": len(self.kept)}
            self.add(
                self.launch(
                    "cluster_borders_keep", len(self.kept), stage,
                    points=self.points, state=self.state, **self._kept,
                )
            )  # fmt: skip

    def steps(self, frame: Frame) -> Sequence[Step]:
        """All that was added; the first frame goes on from where the set-up came to."""
        self._again = self.frame is not None
        return self._steps if self._again else self._steps[self._found :]

    def _unwarp(self, upload: Upload, warp: Warp, stage: str) -> None:
        """Points where the mesh has them, in their warped cells, and how far those let a representative step."""
        self.fill(stage, self.limits, 0)
        launch = self.launch(
            "cluster_warp_points", self._vertices, stage,
            positions=upload.positions, stretch=upload.stretch, points=self.points,
            limits=self.limits.view((self.capacity, 3), np.uint32), vertex_count=self._vertices,
            low=self.grid.arguments["low"], inverse=self.grid.inverse,
            **warp.limits(self.cell_grid, self.grid),
        )  # fmt: skip
        self.add(launch, bytes=2 * POINT * self._vertices + 2 * self.points.size_bytes)

    def place(self) -> None:
        """Fill `points` before the first frame, for what is to be known of them; that frame goes on from there."""
        for step in self._steps:
            step.enqueue(Timeline())
        self._found = len(self._steps)

    def compact(self, stage: str) -> None:
        """The used cells' representatives become the output's vertices, in the order of their cells."""
        grid = self.grid
        self.new_ranks = self.allocate("new_ranks", self.capacity, np.uint32)
        self.vertices_out = self.allocate("vertices", (self.capacity, 3), np.float32, "output")
        self.counts = self.allocate("counts", 2, np.uint32, "output")
        self.add(
            self.launch(
                "cluster_compact", self.capacity, stage,
                solved=self.solved, new_ranks=self.new_ranks, vertices=self.vertices_out,
                counts=self.counts, low=(*grid.low, 0), to_model=(grid.unit, 1 / grid.prescale),
                state=self.state, chunk_sums=self.chunk_sums, capacity=self.capacity,
            ),
            bytes=lambda own: POINT * own.live()[0],
        )  # fmt: skip
        if len(self.kept):
            self.add(
                self.launch(
                    "cluster_borders_keep_return", len(self.kept), stage,
                    positions=self._upload.positions, new_ranks=self.new_ranks,
                    vertices=self.vertices_out, **self._kept,
                )
            )  # fmt: skip
        self.survivors = self.allocate("survivors", (self._triangles, 3), np.uint32, "output")

    def emit(
        self, stage: str, remove_duplicates: bool = False, walked: Mapping[str, Any] | None = None
    ) -> None:
        """The surviving triangles, in input order, with the numbers of their output vertices.

        Args:
            stage: what it counts towards.
            remove_duplicates: keep the first of those with the same three vertices.
            walked: the kernel, by the name "kernel", and its own arguments, where a walk over the triangles has
                noted the survivors already.
        """
        count, joined = self._triangles, self.survivors
        if remove_duplicates:
            joined = self.allocate("joined", (count, 3), np.uint32)
        written = {
            "new_ranks": self.new_ranks, "survivors": joined, "counts": self.counts,
            "triangle_count": count,
        }  # fmt: skip
        if walked is None:
            read = {
                "points": self.points,
                "triangles": self._upload.triangles,
                "chunk_sums": self.chunk_sums,
            }
            self.add(
                self.launch("cluster_emit_count", count, stage, triangle_count=count, **read),
                bytes=POINT * count + WORD * self._vertices,
            )
            launch = self.launch("cluster_emit_write", count, stage, **read, **written)
        else:
            own = {name: value for name, value in walked.items() if name != "kernel"}
            launch = self.launch(walked["kernel"], count, stage, **own, **written)
        self.add(launch, bytes=lambda own: POINT * own.live()[1])
        if remove_duplicates:
            self.counts = self.remove_duplicates(joined, self.survivors, self.counts, stage)

    def remove_duplicates(
        self, joined: Buffer, survivors: Buffer, total: Buffer, stage: str
    ) -> Buffer:
        """The first of triangles with the same three vertices, from `joined` to `survivors`; returns their `counts`."""
        count = joined.shape[0]
        if not any("cluster_duplicates_insert" in program.kernels for program in self._programs):
            with self.setup.host("build"):
                self._programs.append(self.device.build("cluster/duplicates.cl"))
        slot_count = 2 << max(count, 1).bit_length()
        slots = self.allocate("slots", slot_count, np.uint32)
        flags = self.allocate("flags", count, np.uint8)
        counts = self.allocate("counts", 2, np.uint32, "output")
        found = {"joined": joined, "total": total, "slots": slots, "slot_mask": slot_count - 1}
        kept = {"flags": flags, "chunk_sums": self.chunk_sums}
        self.fill(stage, slots, 0xFFFFFFFF)
        for launch in (
            self.launch("cluster_duplicates_insert", count, stage, **found),
            self.launch("cluster_duplicates_count", count, stage, **found, **kept),
            self.launch(
                "cluster_duplicates_write", count, stage,
                joined=joined, total=total, survivors=survivors, counts=counts, **kept,
            ),
        ):  # fmt: skip
            self.add(launch)
        return counts

    def ready(self, *kernels: Any) -> None:
        """Set the output; run a frame, unless this device has run one with these `kernels`."""
        surface = DeviceSurface(
            positions=self.vertices_out,
            normals=None,
            triangles=self.survivors,
            vertex_count=self.capacity,
            triangle_count=self._triangles,
            counts=self.counts,
        )
        self.output = (surface,)
        warp = self._upload.warp
        key, warm = (
            (type(self), warp and warp.kernel, *kernels),
            _warm.setdefault(self.device, set()),
        )
        self.setup.from_cache["first_launch"] = key in warm
        if key not in warm:
            self.warm_up()
            warm.add(key)

    def read_counts(self, counts: Sequence[Buffer]) -> Sequence[NDArray[np.uint32]]:
        """As every subject's; read with them is whether the cells are as many as in set-up, if they were found anew."""
        if not self._again:
            return super().read_counts(counts)
        *found, state = super().read_counts([*counts, self.state])
        if (occupied := int(state[0])) > self.capacity:
            raise DeviceError(
                f"cells: expected {self.capacity} occupied as in set-up, got {occupied}"
            )
        return found

    def read_back(self) -> tuple[TriangleMesh, NDArray[np.uint32]]:
        """The last frame's mesh, and `vertex_map`, after a single wait."""
        vertices, triangles = self.live()
        wanted = [(self.vertices_out, vertices), (self.survivors, triangles)]
        if self._map_out is not None:
            positions, survivors = self.device.read_all(*wanted)
            return TriangleMesh.of_kernels(positions, survivors), self._vertex_map
        positions, survivors, vertex_map = self.device.read_all(*wanted, (self.map_now(), None))
        return TriangleMesh.of_kernels(positions, survivors), vertex_map

    def sources(self) -> NDArray[np.intp]:
        """The input triangles of the last frame's output triangles, ascending, and of duplicates that were removed."""
        count, device = self._triangles, self.device
        chunks = chunk_count(device, count)
        program = device.build("cluster/sources.cl")
        rows = device.allocate("rows", count, np.uint32)
        bounds = device.allocate("bounds", (chunks, 2), np.uint32)
        program.launch(
            "cluster_sources", chunks, stage="sources", local=chunk_local(device),
            triangles=self._upload.triangles, vertex_map=self.map_now(), rows=rows, bounds=bounds,
            triangle_count=count, chunk_count=chunks,
        )(Timeline())  # fmt: skip
        found, ends = device.read_all((rows, None), (bounds, None))
        return np.concatenate([found[a:b] for a, b in ends.tolist()]).astype(np.intp)

    def mapping(self) -> tuple[Launch, Buffer]:
        """What writes `vertex_map`, and where to."""
        result = self.device.allocate("vertex_map", self._vertices, np.uint32)
        launch = self.launch(
            "cluster_cells_map", self._vertices, "vertex_map",
            points=self.points, new_ranks=self.new_ranks, vertex_map=result,
            vertex_count=self._vertices,
        )  # fmt: skip
        return launch, result

    def counters(self) -> Mapping[str, int | float]:
        """Vertices and triangles, `more_counters`, and output triangles that say nothing of the surface."""
        distinct = self.params.remove_duplicates
        return {**super().counters(), **turned.counted(self._mesh, *self.read_back(), distinct)}

    def more_counters(self) -> Mapping[str, int | float]:
        """Sizes in, and occupied cells: what is known at once.

        `cells_x`, `cells_y`, `cells_z` are those along each axis. With a target also `target`, `target_gap`
        (triangles short of it, negative where there are more), `counting_passes` and `cells_along_longest`.
        """
        counters: dict[str, int | float] = {
            "vertices_in": self._vertices,
            "triangles_in": self._triangles,
            "cells": self.cell_grid.cell_count,
            **{f"cells_{axis}": n for axis, n in zip("xyz", self.cell_grid.counts, strict=True)},
            "cells_occupied": self.occupied,
            "border_edges": len(self.border),
        }
        if self.found is not None:
            counters |= missed(self.found.target, self.live()[1])
            counters["counting_passes"] = self.found.counts
            counters["cells_along_longest"] = self.found.cells or 0.0
        return counters
