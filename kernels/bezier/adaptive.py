"""What both adaptive tessellations share on a device: test and count, scan, emit, room that grows, the check."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import BezierPatches, TriangleMesh
from lodbench.kernels.bezier import borders
from lodbench.kernels.bezier.adaptive_check import judged
from lodbench.kernels.bezier.adaptive_params import AdaptiveParams
from lodbench.kernels.bezier.candidates import (
    CELL,
    DEEPEST,
    NODES,
    Flags,
    cell_samples,
    nodes_of,
    ways_of,
)
from lodbench.kernels.bezier.divergence import divergence
from lodbench.kernels.bezier.grids import (
    PIECES,
    piece_levels,
    piece_triangles,
)
from lodbench.kernels.bezier.lattice import side_vertices, stored_map
from lodbench.kernels.bezier.measures import TESTS, inverse_diagonal, screen_rows
from lodbench.kernels.bezier.sources import normal_sources
from lodbench.kernels.bezier.tessellated import (
    CONTROL_FLOATS,
    check_size,
    control_rows,
    shared_normals,
    vertex_total,
)
from lodbench.kernels.launching import group_size
from lodbench.kernels.opencl import Device, Launch, Program, Timeline
from lodbench.kernels.stages.scan import ExclusiveScan
from lodbench.kernels.subject import POINT, DeviceSubject, Step
from lodbench.kernels.system import Check, DeviceSurface, Frame, Stored, View

FIRST_SHARE = 0.25  # of the vertices and triangles that there can be: room to begin with
FIRST_VERTICES = 1 << 16  # or for so many
SPARE = 1.25  # times the room that a frame needed
MOST_VERTICES, MOST_TRIANGLES = NODES, CELL * CELL  # of a coarse triangle


class Adaptive(DeviceSubject):
    """Patches whose coarse triangles insert vertices by tests.

    A system calls `build`, and `prepare` once it has uploaded what its kernels read beyond what is here. It says in
    `inserted` which nodes a coarse triangle has, from which pass the test.

    Raises:
        ValueError: more vertices than 32-bit indices can name, or a coordinate that the sums cannot bear.
        Unsupported: the output does not fit the device's memory.
    """

    inserted: Callable[[Flags, Flags, int], Flags]
    _tests: Program
    _program: Program

    def __init__(self, device: Device, patches: BezierPatches, params: AdaptiveParams) -> None:
        super().__init__(device)
        self._patches, self._params = patches, params
        self.count = len(patches.points)
        check_size(patches.points)
        self._level = params.base + DEEPEST  # of the map
        self.cells = self.count * 4**params.base
        vertex_total(2 * self.cells, MOST_VERTICES)
        self._inverse = inverse_diagonal(patches.points)
        with self.setup.host("borders"):
            self._borders = borders.borders_of(patches.points)
        with self.setup.host("upload"):
            self._controls = self.upload("controls", control_rows(patches.points), np.float32)
            self._map = self.upload("map", stored_map(self._level), role="pattern")
            self._sources = self.upload("sources", normal_sources(self._borders), role="pattern")
        self._masks = self.allocate("masks", 2 * self.cells, np.uint64)
        names = "vertex", "triangle"
        self._sizes = {f"{n}_counts": self.allocate(n, self.cells, np.uint32) for n in names}
        self._offsets = [self.allocate(f"{n}_offsets", self.cells, np.uint32) for n in names]
        self._totals = [self.allocate(f"{n}_total", 1, np.uint32) for n in names]
        self._counts = self.allocate("counts", 2, np.uint32, "output")
        self._testing: Launch | None = None
        self._seen: View | None = None

    def build(self, *files: str, **defines: int) -> Program:
        """The system's kernels, by test and what else they are built with."""
        defines |= {"TEST": TESTS[self._params.test], "STREAMING": 1}
        with self.setup.host("build"):  # what a test has no use for would not be left out
            self._tests, self._program = (
                self.device.build(*files, defines=defines | {"NORMALS": int(normals)})
                for normals in (self._params.test == "flat", self._params.evaluates_normals)
            )
        return self._program

    def prepare(self, kernel: str, tested: Mapping[str, Any], emitted: Mapping[str, Any]) -> None:
        """The steps of a frame, and one frame to warm up.

        Args:
            kernel: what the names of the program's kernels `kernel`_test and `kernel`_emit begin with.
            tested: further arguments of the first, which `emitted` are of the second.
        """
        params, cells = self._params, self.cells
        least = params.least if params.test == "flat" else params.least**2
        self._testing = self._tests.launch(
            f"{kernel}_test", cells, stage="geometry_test", local=group_size(self.device),
            map=self._map, controls=self._controls, masks=self._masks, **self._sizes,
            screen=self._screen(None), measure=(self._inverse, min(least, 1e38)),
            map_stride=self._map.shape[1], side=side_vertices(self._level),
            depth=params.finest_depth, cell_count=cells, **tested,
        )  # fmt: skip
        self.add(self._testing, bytes=4 * CONTROL_FLOATS * self.count + 24 * cells)
        self.finish(f"{kernel}_emit", emitted)

    def finish(self, emit: str, emitted: Mapping[str, Any]) -> None:
        """After the steps that test: where vertices begin, room for them, what emits them, a frame to warm up."""
        self._emit = emit, emitted
        sizes = self._sizes.values()
        for counts, offsets, total in zip(sizes, self._offsets, self._totals, strict=True):
            with self.holding("scratch"):
                scan = ExclusiveScan(self.device, counts, offsets, total)
            self.add(scan, bytes=8 * self.cells, stage="scan")
        self._fixed = len(self._steps)
        most = 2 * self.cells * np.array([MOST_VERTICES, MOST_TRIANGLES])
        self._make_room(
            *np.minimum(most, np.maximum(FIRST_SHARE * most, FIRST_VERTICES)).astype(int)
        )
        self.warm_up()
        if self.overflowed():
            self.grow()
            self.warm_up()

    def _screen(self, view: View | None) -> tuple[float, ...]:
        rows = screen_rows(view, self._inverse)
        return tuple(float(np.float32(value)) for value in rows.ravel())

    def _make_room(self, vertices: int, triangles: int) -> None:
        """The output's buffers and the launch that fills them.

        Raises:
            Unsupported: the device has no room for them.
        """
        normals = self._params.evaluates_normals
        self._positions = self.allocate("positions", (vertices, 3), np.float32, "output")
        self._normals = self.allocate(
            "normals", (vertices if normals else 0, 3), np.float32, "output"
        )
        self._triangles = self.allocate("triangles", (triangles, 3), np.uint32, "output")
        self._room = int(vertices), int(triangles)
        name, more = self._emit
        launch = self._program.launch(
            name, self.cells, stage="geometry_emit", local=group_size(self.device),
            controls=self._controls, sources=self._sources, masks=self._masks,
            vertex_offsets=self._offsets[0], triangle_offsets=self._offsets[1],
            vertex_total=self._totals[0], triangle_total=self._totals[1],
            positions=self._positions, normals=self._normals, triangles=self._triangles,
            counts=self._counts, side=side_vertices(self._level),
            vertex_room=self._room[0], triangle_room=self._room[1], cell_count=self.cells, **more,
        )  # fmt: skip
        del self._steps[self._fixed :]
        size = POINT * (1 + normals)
        self.add(launch, bytes=lambda own: size * own.live()[0] + POINT * own.live()[1])
        self.output = (
            DeviceSurface(
                self._positions, self._normals if self._params.normals else None, self._triangles, *self._room,
                counts=self._counts,
            ),
        )  # fmt: skip

    def steps(self, frame: Frame) -> Sequence[Step]:
        """Tests by the frame's view, counts, and what they emit."""
        if not self.count:
            return ()
        if frame.view is not self._seen and self._testing:
            self._testing.set(screen=self._screen(frame.view))
            self._seen = frame.view
        return self._steps

    # room

    def needed(self) -> tuple[int, int]:
        """Vertices and triangles of the last frame, whether there was room for them or not."""
        if not self.count:
            return 0, 0
        vertices, triangles = self.device.read_all(*((total, None) for total in self._totals))
        return int(vertices[0]), int(triangles[0])

    def overflowed(self) -> bool:
        """See `Growing`."""
        vertices, triangles = self.needed()
        return vertices > self._room[0] or triangles > self._room[1]

    def grow(self) -> None:
        """See `Growing`."""
        most = MOST_VERTICES, MOST_TRIANGLES
        room = [
            max(room, min(int(SPARE * needed), 2 * self.cells * each))
            for needed, room, each in zip(self.needed(), self._room, most, strict=True)
        ]
        gone = self._positions, self._normals, self._triangles
        self.release("output", *gone)
        self.output = ()
        for buffer in gone:
            buffer.release()
        self._make_room(*room)

    def live_rows(self) -> list[tuple[int, int]]:
        """Vertices and triangles of the last frame."""
        if self.frame is None:
            self.enqueue(Frame(), Timeline())
        return [self.needed()]

    # afterwards

    def masks(self) -> NDArray[np.uint64]:
        """The last frame's inserted nodes of each coarse triangle and its way, (m, cells, 2)."""
        if self.frame is None:
            self.enqueue(Frame(), Timeline())
        found = self.device.read(self._masks) if self.count else np.zeros(0, np.uint64)
        return found.view(np.uint64).reshape(-1, 4**self._params.base, 2)

    def vertex_places(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The patch of each vertex of the last frame, and which virtual vertex of the map of `map_level` it is."""
        masks = self.masks()
        patch, cell, triangle, node = np.nonzero(nodes_of(masks))
        way = ways_of(masks)[patch, cell, triangle]
        return patch, cell_samples(self._level)[cell, PIECES[way, node]]

    @property
    def map_level(self) -> int:
        """The level of the map from which vertices come."""
        return self._level

    def triangle_levels(self) -> NDArray[np.int64]:
        """Of each triangle of the last frame, the finest level of its coarse triangle: 0 to 3."""
        masks = self.masks().ravel()
        return np.repeat(piece_levels(masks), piece_triangles(masks))

    def welded(self) -> TriangleMesh:
        """The last frame's mesh with every shared vertex once, and triangles at collapsed edges left out.

        Where patches meet at an angle a vertex has the mean of their normals.
        """
        (mesh,) = self.result()
        lattice, _ = borders.sharing(self._borders, self._level)
        _, first, vertex = np.unique(
            lattice[self.vertex_places()], return_index=True, return_inverse=True
        )
        vertex = vertex.reshape(-1).astype(np.uint32)
        triangles = vertex[mesh.triangles]
        a, b, c = triangles.T
        triangles = triangles[(a != b) & (b != c) & (c != a)]
        normals = mesh.normals
        if normals is not None:
            normals = shared_normals(normals, vertex, first)
        return TriangleMesh(mesh.positions[first], triangles, normals)

    def check(self) -> Check:
        """Inserted nodes, points, normals and triangles of some patches, spread over all, against float64."""
        (mesh,) = self.result()
        view = None if self.frame is None else self.frame.view
        return judged(
            self._patches, self._params, view, mesh, self.masks(), self.vertex_places(),
            type(self).inserted,
        )  # fmt: skip

    def more_counters(self) -> Mapping[str, int | float]:
        """The coarse triangles, how their levels are spread, and how unlike their work is."""
        masks = self.masks().ravel()
        flags, levels = nodes_of(masks), np.bincount(piece_levels(masks), minlength=DEEPEST + 1)
        return {
            "patches": self.count,
            "coarse_triangles": 2 * self.cells,
            "segments": 1 << self._params.level,
            "threshold": self._params.least,
            "launches": len(self._steps),
            **{f"level_{level}_triangles": int(n) for level, n in enumerate(levels)},
            **divergence(self.work(flags)),
            **self._borders.counts(),
        }

    def work(self, flags: Flags) -> NDArray[np.int64]:
        """What each coarse triangle has to do: candidates tested, and vertices emitted."""
        raise NotImplementedError(f"{type(self).__name__}.work: expected of every system")

    def stored(self) -> Stored:
        """Stored are the map and the control points; a static buffer stores every vertex and index."""
        vertices, triangles = self.live()
        size = POINT * (1 + self._params.normals)
        return Stored(
            stored_vertices=side_vertices(self._level),
            stored_bytes=self._bytes["pattern"] + self._bytes["input"],
            static_vertices=vertices,
            static_bytes=size * vertices + POINT * triangles,
        )
