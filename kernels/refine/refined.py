"""Patterns over a coarse mesh: launches for every level and batch are made, a frame enqueues one level's."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lodbench.datasets_gen.surfaces import Floats, TriangleMesh
from lodbench.kernels.launching import LINE, VERTEX_BYTES, group_size, kernel_defines
from lodbench.kernels.opencl import Buffer, Device, Timeline
from lodbench.kernels.refine.lattice import (
    lattice_interpolation,
    lattice_triangles,
    lattice_vertex_count,
    lattice_weights,
    refined_mesh,
    welded_mesh,
)
from lodbench.kernels.refine.levels import Batch, Level
from lodbench.kernels.refine.params import LevelParams
from lodbench.kernels.refine.surface import TOLERANCE, Coarse, Surface
from lodbench.kernels.subject import DeviceSubject, Step
from lodbench.kernels.system import Check, DeviceSurface, Footprint, Frame, Stored

if TYPE_CHECKING:
    from lodbench.kernels.opencl import Launch, Program


def _joined(parts: Sequence[Floats]) -> Floats:
    """The parts one after the other; a single one is not copied."""
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


class Refined(DeviceSubject):
    """A pattern, or all of its levels, over a mesh with its own normals, or area-weighted ones.

    Attributes:
        more_files: kernels that a system has of its own.

    Raises:
        ValueError: a coordinate that the surface cannot bear.
        Unsupported: not even one refined triangle fits the device's memory.
    """

    more_files: tuple[str, ...] = ()

    def __init__(
        self, device: Device, mesh: TriangleMesh, params: LevelParams, surface: Surface
    ) -> None:
        super().__init__(device)
        self._params = params
        self._coarse = Coarse(self, mesh, params, surface)
        self._mesh, self._displacement = self._coarse.mesh, self._coarse.displacement
        count = mesh.triangle_count
        with self.setup.host("upload"):
            patterns = [self._upload(params.segments >> k) for k in range(params.levels)]
        finest = lattice_vertex_count(params.segments)
        free = device.memory_limit - device.used_bytes
        largest = device.facts.largest_allocation_bytes
        room = min(free // (VERTEX_BYTES * finest), 2 * largest // (VERTEX_BYTES * finest))
        self._capacity = finest * (min(count, max(room, 1)) if count else 0)
        self._allocate_output()
        with self.setup.host("build"):
            defines = kernel_defines(device, VERTEX_BYTES * self._capacity)
            self._chunk = defines["CHUNK"]
            files = (*self._coarse.files, *self.more_files, "refine/vertex.cl")
            program = device.build(*files, defines=defines | self._displacement.defines)
        self._levels = [self._level(program, *pattern) for pattern in patterns]
        with self.setup.host("first_launch"):
            for level in reversed(self._levels):
                for step in level.steps:
                    step.enqueue(Timeline())
        self.warm_up()

    def _allocate_output(self) -> None:
        shape = (self._capacity, 3)
        self._positions = self.allocate("positions", shape, np.float32, "output")
        self._normals = self.allocate("normals", shape, np.float32, "output")

    def _upload(self, segments: int) -> tuple[int, Buffer, Buffer]:
        """A pattern's weights, padded so that a vector may begin at its last vertex, and its triangles."""
        count = lattice_vertex_count(segments)
        planes = np.zeros((2, -(-count // LINE) * LINE + LINE), np.float32)
        planes[:, :count] = lattice_weights(segments).T[1:]
        weights = self.upload("pattern", planes, np.float32, (2, None), "pattern")
        indices = lattice_triangles(segments)
        triangles = self.upload("triangles", indices, np.uint32, role="pattern")
        return segments, weights, triangles

    def _level(self, program: Program, segments: int, weights: Buffer, triangles: Buffer) -> Level:
        total, vertices = self._mesh.triangle_count, lattice_vertex_count(segments)
        surface = DeviceSurface(
            self._positions,
            self._normals,
            triangles,
            vertex_count=total * vertices,
            triangle_count=total * segments * segments,
            instances=total,
            instance_vertices=vertices,
        )
        level = Level(segments, weights, triangles, surface)
        each = max(self._capacity // vertices, 1)
        for first in range(0, total, each):
            batch = Batch(first, min(each, total - first))
            level.batches.append(batch)
            batch.launches = self._launches(program, level, batch)
            batch.steps = [self._step(level, batch, launch) for launch in batch.launches]
        return level

    def _step(self, level: Level, batch: Batch, launch: Launch) -> Step:
        """The output must be written, attributes and pattern read once; operations are counted from the kernel."""
        triangles = batch.count // len(batch.launches)
        first = launch is level.batches[0].launches[0]
        size = (VERTEX_BYTES * level.vertices + self._coarse.triangle_bytes) * triangles
        pattern = 8 * level.vertices if first else 0
        return Step(
            launch, launch.stage, size + pattern, self._coarse.flops * level.vertices * triangles
        )

    def _arguments(self, level: Level) -> dict[str, Any]:
        return {
            "pattern": level.weights,
            "positions": self._positions,
            "normals": self._normals,
            "displacement": self._displacement.value(0.0),
            "table": self._coarse.table,
            "attributes": self._coarse.attributes,
            "pattern_stride": level.weights.shape[1],
            "last_row": level.vertices - level.segments - 1,
            "pattern_vertices": level.vertices,
        }

    def _launches(self, program: Program, level: Level, batch: Batch) -> list[Launch]:
        """The launches that write a batch: one for all of its triangles."""
        vertex_count = batch.count * level.vertices
        launch = program.launch(
            "refine_vertex",
            -(-vertex_count // self._chunk),
            stage="vertex",
            local=group_size(self.device),
            surface=self._coarse.values,
            first_triangle=batch.first,
            vertex_count=vertex_count,
            **self._arguments(level),
        )
        return [launch]

    def _choose(self, frame: Frame) -> Level:
        """The finest level within `near`, one coarser for each doubling of the eye's distance from the box."""
        if frame.view is None:
            return self._levels[0]
        low, high = self._mesh.box
        eye = np.asarray(frame.view.eye, np.float64)
        distance = float(np.linalg.norm(eye - np.clip(eye, low, high))) / self._coarse.diagonal
        halvings = int(np.floor(np.log2(max(distance / self._params.near, 1.0))))
        return self._levels[min(halvings, len(self._levels) - 1)]

    def steps(self, frame: Frame) -> Sequence[Step]:
        """The pattern of the frame's level over all coarse triangles; no surface where it did not fit at once."""
        level, self._time = self._choose(frame), frame.time
        self._drawn = level
        self.output = (level.surface,) if len(level.batches) <= 1 else ()
        if self._displacement.is_any:
            for batch in level.batches:
                for launch in batch.launches:
                    launch.set(displacement=self._displacement.value(frame.time))
        return level.steps

    def _read(self) -> Iterator[tuple[Batch, Floats, Floats]]:
        """Points and normals batch by batch, (count, pattern vertices, 3) each; several are run again."""
        level = self._drawn
        for batch in level.batches:
            if len(level.batches) > 1:
                for step in batch.steps:
                    step.enqueue(Timeline())
            rows = batch.count * level.vertices
            shape = (batch.count, level.vertices, 3)
            yield (
                batch,
                self.device.read(self._positions, rows).reshape(shape),
                self.device.read(self._normals, rows).reshape(shape),
            )

    def result(self) -> Sequence[TriangleMesh]:
        """The last frame's mesh, whose refined triangles share no vertices: instance after instance.

        An instance begins at its coarse triangle's vertex of lowest number.

        Raises:
            ValueError: a user's function raised points to infinity or NaN.
        """
        none = [(None, np.zeros((0, 3), np.float32), np.zeros((0, 3), np.float32))]
        _, points, directions = zip(*(list(self._read()) or none), strict=True)
        positions, normals = _joined(points), _joined(directions)
        self._displacement.check_heights(positions)
        return [
            refined_mesh(
                self._mesh, self._drawn.segments, positions.reshape(-1, 3), normals.reshape(-1, 3)
            )
        ]

    def welded(self) -> TriangleMesh:
        """The last frame's mesh with every shared vertex once, matched by edge and place on it."""
        return welded_mesh(self.result()[0], self._mesh.triangles, self._drawn.segments)

    def at_parameters(self) -> Floats:
        """See `Parametric`: at the vertices of the finest level."""
        vertices, weights = lattice_interpolation(self._drawn.segments, self._params.segments)
        parts = [
            np.einsum("kn,mknd->mnd", weights.astype(np.float32), points[:, vertices])
            for _, points, _ in self._read()
        ]
        return _joined(parts or [np.zeros((0, 3), np.float32)]).reshape(-1, 3)

    def check(self) -> Check:
        """Points and normals of some coarse triangles, spread over the mesh, against float64."""
        chosen = self._coarse.chosen()
        weights = lattice_weights(self._drawn.segments)
        worst = 0.0
        for batch, positions, normals in self._read():
            rows = chosen[(chosen >= batch.first) & (chosen < batch.first + batch.count)]
            if len(rows):
                here = rows - batch.first
                error = self._coarse.error(
                    rows, positions[here], normals[here], weights, self._time
                )
                worst = float(np.max([worst, error]))  # NaN is the worst of all
        what = (
            "largest error of points (over the largest coordinate) and of unit normals, "
            f"{len(chosen)} of {self._coarse.count} coarse triangles{self._displacement.remark}"
        )
        return Check(worst <= TOLERANCE, what, worst, TOLERANCE)

    def live(self) -> tuple[int, int]:
        """Vertices and triangles of the last frame's surface, whether it fitted at once or not."""
        return self._drawn.surface.vertex_count, self._drawn.surface.triangle_count

    def more_counters(self) -> Mapping[str, int | float]:
        """The coarse mesh, the level, and the vertices that stay stored as the paper counts them: a square grid's."""
        segments = self._drawn.segments
        return {
            "coarse_triangles": self._mesh.triangle_count,
            "cracked_edges": self._coarse.cracked_edges,
            "segments": segments,
            "vertices_square_grid": (segments + 1) ** 2,
            "launches": len(self._drawn.steps),
        }

    def stored(self) -> Stored:
        """Stored are the patterns and the coarse attributes; a static buffer stores every vertex and index."""
        vertices, triangles = self.live()
        return Stored(
            stored_vertices=sum(level.vertices for level in self._levels),
            stored_bytes=self._bytes["pattern"] + self._bytes["input"],
            static_vertices=vertices,
            static_bytes=VERTEX_BYTES * vertices + 12 * triangles,
        )

    def footprint(self) -> Footprint:
        """As every subject's, in so many batches."""
        return replace(super().footprint(), batches=max(len(self._drawn.batches), 1))
