"""Adaptive patterns over a coarse mesh: tags, selection, scan and refinement, all on the device."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lodbench.datasets_gen.surfaces import Floats, TriangleMesh
from lodbench.kernels.launching import VERTEX_BYTES, group_size, kernel_defines
from lodbench.kernels.opencl import Device, Launch, Timeline
from lodbench.kernels.refine.adaptive_patterns.choosing import FOLDER, Choosing
from lodbench.kernels.refine.adaptive_patterns.params import Params
from lodbench.kernels.refine.adaptive_patterns.pool import pool
from lodbench.kernels.refine.adaptive_patterns.reference import edge_depths, morphed
from lodbench.kernels.refine.adaptive_patterns.sharing import (
    in_patterns,
    interpolated,
    sharing,
    to_lattice,
)
from lodbench.kernels.refine.adaptive_patterns.tags import measures
from lodbench.kernels.refine.lattice import joined_mesh
from lodbench.kernels.refine.surface import TOLERANCE
from lodbench.kernels.subject import POINT, Step
from lodbench.kernels.system import Check, DeviceSurface, Frame, Stored

FIRST_DEPTH = 3  # room for so much of every triangle, to begin with
SPARE = 1.25  # times the room that a frame needed


class AdaptivePatterns(Choosing):
    """A mesh under adaptive patterns: see `lodbench.kernels.refine.adaptive_patterns`.

    Args:
        device: where it runs.
        mesh: the coarse mesh.
        params: what asks for how much.
        depths: (n,) depth tag of each vertex, 0 to the finest depth, with by="given".

    Raises:
        ValueError: depths where none are asked for, or none where they are; a coordinate that the surface cannot bear.
        Unsupported: no room on the device.
    """

    def __init__(
        self,
        device: Device,
        mesh: TriangleMesh,
        params: Params,
        depths: ArrayLike | None = None,
    ) -> None:
        super().__init__(device, mesh, params, depths)
        self._choices, self._seen = len(self._steps), None
        start = pool(min(params.finest, FIRST_DEPTH))
        each = int(start.vertex_counts[-1]), int(start.triangle_counts[-1])
        self._make_room(each[0] * self._coarse.count, each[1] * self._coarse.count)
        self.warm_up()

    def _make_room(self, vertices: int, faces: int) -> None:
        """The output's buffers and the launches that fill them.

        Raises:
            Unsupported: the device has no room for them.
        """
        device, coarse = self.device, self._coarse
        self._positions = self.allocate("positions", (vertices, 3), np.float32, "output")
        self._normals = self.allocate("normals", (vertices, 3), np.float32, "output")
        listed = faces if self._params.indices else 0
        self._triangles = self.allocate("triangles", (listed, 3), np.uint32, "output")
        self._room = vertices, faces
        with self.setup.host("build"):
            defines = kernel_defines(device, VERTEX_BYTES * vertices)
            files = (*coarse.files, f"{FOLDER}/vertex.cl")
            written = device.build(*files, defines=defines | coarse.displacement.defines)
            more = (f"{FOLDER}/indices.cl", f"{FOLDER}/morph.cl")
            chunk = defines["CHUNK"]
            program = device.build(*more, defines={"CHUNK": chunk})
        place: dict[str, Any] = {
            "records": self._records, "patterns": self._patterns, "offsets": self._offsets,
            "triangle_count": coarse.count,
        }  # fmt: skip
        local = group_size(device)
        self._writing = written.launch(
            "adaptive_patterns_vertex", -(-vertices // chunk), stage="vertex", local=local,
            pool=self._weights, totals=self._totals,
            surface=coarse.values, table=coarse.table, attributes=coarse.attributes,
            positions=self._positions,
            normals=self._normals, counts=self._counts,
            displacement=coarse.displacement.value(0.0), pool_stride=self._weights.shape[1],
            vertex_room=vertices, face_room=faces, **place,
        )  # fmt: skip
        del self._steps[self._choices :]
        self.add(
            self._writing,
            bytes=lambda own: VERTEX_BYTES * own.live()[0] + own.coarse_bytes,
            flops=lambda own: own.vertex_flops * own.live()[0],
        )
        if self._params.geomorphing:
            self.add(self._morphing(program, place), lambda own: VERTEX_BYTES * own.live()[0])
        if self._params.indices and faces:
            listing = program.launch(
                "adaptive_patterns_indices", -(-faces // chunk), stage="indices", local=local,
                lists=self._lists, starts=self._starts, counts=self._counts,
                triangles=self._triangles, **place,
            )  # fmt: skip
            self.add(listing, bytes=lambda own: POINT * own.live()[1])
        surface = DeviceSurface(
            self._positions, self._normals, self._triangles, vertices, faces, counts=self._counts
        )
        self.output = (surface,) if self._params.indices else ()

    def _morphing(self, program: Any, place: dict[str, Any]) -> Launch:
        return program.launch(
            "adaptive_patterns_morph", self._coarse.count, stage="morph", moves=self._moves,
            blends=self._blends, counts=self._counts, positions=self._positions,
            normals=self._normals, **place,
        )  # fmt: skip

    @property
    def coarse_bytes(self) -> int:
        """What the kernels read of all triangles."""
        return self._coarse.triangle_bytes * self._coarse.count

    @property
    def vertex_flops(self) -> int:
        """Operations of one vertex."""
        return self._coarse.flops

    def steps(self, frame: Frame) -> Sequence[Step]:
        """Tags by the frame's eye, patterns, and their vertices."""
        self._frame = frame
        if not self._coarse.count:
            return ()
        if frame.view is not self._seen:
            eye, measure = measures(self._params, frame.view, self._coarse.diagonal)
            self._tagging.set(eye=eye, measure=measure)
            self._seen = frame.view
        if self._coarse.displacement.is_any:
            self._writing.set(displacement=self._coarse.displacement.value(frame.time))
        return self._steps

    def overflowed(self) -> bool:
        """See `Growing`."""
        vertices, faces = self.needed()
        return vertices > self._room[0] or faces > self._room[1]

    def grow(self) -> None:
        """See `Growing`."""
        every = self.pool.vertex_counts[-1], self.pool.triangle_counts[-1]
        needed = (
            max(room, min(int(SPARE * n), int(most) * self._coarse.count))
            for n, room, most in zip(self.needed(), self._room, every, strict=True)
        )
        gone = self._positions, self._normals, self._triangles
        self.release("output", *gone)
        for buffer in gone:
            buffer.release()
        self.output = ()
        self._make_room(*needed)

    def live_rows(self) -> list[tuple[int, int]]:
        """Of the last frame, whether its triangles are listed or not."""
        if self.frame is None:
            self.enqueue(Frame(), Timeline())
        return [self.needed()]

    def result(self) -> Sequence[TriangleMesh]:
        """The last frame's mesh, whose coarse triangles share no vertices: one after the other."""
        vertices, faces = self.live()
        numbers, offsets = self.chosen()
        points = self.device.read(self._positions, vertices).reshape(-1, 3)
        self._coarse.displacement.check_heights(points)
        normals = self.device.read(self._normals, vertices).reshape(-1, 3)
        if self._params.indices:
            triangles = self.device.read(self._triangles, faces).reshape(-1, 3)
        else:
            starts = self.device.read(self._starts)
            triangles = np.empty((faces, 3), np.uint32)
            for pattern, rows, _ in in_patterns(numbers, offsets, self._params.finest):
                own = pattern.triangles
                places = starts[rows, None].astype(np.int64) + np.arange(len(own))
                triangles[places] = own + offsets[rows, None, None]
        others = interpolated(self._mesh, numbers, offsets, self._params.finest)
        return [TriangleMesh(points, triangles, normals, **others)]

    def welded(self) -> TriangleMesh:
        """The last frame's mesh with every shared vertex once, matched by edge and place on it."""
        mesh = self.result()[0]
        shared = sharing(self._mesh.triangles, *self.chosen(), self._params.finest)
        return joined_mesh(mesh, *shared)

    def at_parameters(self) -> Floats:
        """See `Parametric`: at the lattice of the finest depth."""
        points = self.device.read(self._positions, self.live()[0]).reshape(-1, 3)
        made = np.zeros((self._coarse.count, self.pool.lattice_vertices, 3), np.float32)
        for pattern, rows, slots in in_patterns(*self.chosen(), self._params.finest):
            there = to_lattice(pattern, self._params.finest) @ points[slots.T].reshape(
                len(pattern.used), -1
            )
            made[rows] = there.reshape(-1, len(rows), 3).swapaxes(0, 1)
        return made.reshape(-1, 3)

    def check(self) -> Check:
        """Tags and patterns against numpy, points and normals of some coarse triangles against float64."""
        params, coarse = self._params, self._coarse
        _, blends = edge_depths(self._mesh.triangles, self.tags(), params.finest)
        numbers, offsets = self.chosen()
        vertices = self.live()[0]
        positions = self.device.read(self._positions, vertices).reshape(-1, 3)
        normals = self.device.read(self._normals, vertices).reshape(-1, 3)
        chosen, worst = coarse.chosen(), float(self.wrong_patterns())
        for pattern, rows, slots in in_patterns(numbers, offsets, params.finest):
            some = np.isin(rows, chosen)
            if some.any():
                weights = pattern.integer_weights / (1 << pattern.depth)
                taken = rows[some]
                points, directions = positions[slots[some]], normals[slots[some]]
                then = partial(morphed, pattern, blends=blends[taken])
                more = {"then": then} if params.geomorphing else {}
                error = coarse.error(taken, points, directions, weights, self._frame.time, **more)
                worst = float(np.max([worst, error]))  # NaN is the worst of all
        what = (
            "largest error of points (over the largest coordinate) and of unit normals, or wrong patterns, "
            f"{len(chosen)} of {coarse.count} coarse triangles{coarse.displacement.remark}"
        )
        return Check(worst <= TOLERANCE, what, worst, TOLERANCE)

    def more_counters(self) -> Mapping[str, int | float]:
        """The coarse mesh, the patterns in use, and what the pool holds."""
        vertices = self.pool.lattice_vertices
        return {
            "coarse_triangles": self._coarse.count,
            "cracked_edges": self._coarse.cracked_edges,
            "segments": self._params.segments,
            "patterns": len(self.pool.vertex_counts),
            "patterns_used": len(np.unique(self.chosen()[0])),
            "lattice_vertices": vertices,
            "pool_triangles": len(self.pool.triangles),
            "pool_index_bytes": self.pool.triangles.nbytes,
            "pool_bytes": self._bytes["pattern"],
        }

    def stored(self) -> Stored:
        """Stored are the pool and the coarse attributes; a static buffer stores every vertex and index."""
        vertices, faces = self.live()
        return Stored(
            stored_vertices=self.pool.lattice_vertices,
            stored_bytes=self._bytes["pattern"] + self._bytes["input"],
            static_vertices=vertices,
            static_bytes=VERTEX_BYTES * vertices + POINT * faces,
        )
