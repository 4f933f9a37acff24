"""Patches that have a level each: chosen, counted, tessellated level by level, and joined without cracks.

An edge has one level, which both of its patches know from its own control points, or as the coarser of the two. Where a
patch is finer, its vertices on the edge come together in those of the edge's level: triangles there may have no area.
All points on borders, and normals along smooth ones, are then evaluated in one place, by one sum (`levels.cl`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from lodbench.datasets_gen.surfaces import BezierPatches, TriangleMesh
from lodbench.kernels.bezier import borders
from lodbench.kernels.bezier.arrangement import Arrangement
from lodbench.kernels.bezier.lattice import side_vertices
from lodbench.kernels.bezier.level_params import LeveledParams
from lodbench.kernels.bezier.level_places import (
    border_places,
    edge_levels,
    judged,
    snapped_vertices,
)
from lodbench.kernels.bezier.sources import normal_sources
from lodbench.kernels.bezier.tessellated import (
    CONTROL_FLOATS,
    check_size,
    control_rows,
    shared_normals,
    vertex_total,
)
from lodbench.kernels.launching import group_size
from lodbench.kernels.opencl import Buffer, Device, Launch
from lodbench.kernels.stages.camera import pixel_rows
from lodbench.kernels.stages.scan import ExclusiveScan
from lodbench.kernels.subject import POINT, DeviceSubject, Step
from lodbench.kernels.system import Check, DeviceSurface, Frame, View

INDEX_CHUNK = 256  # as in levels.cl

Launches = Callable[["Leveled", int], Iterable[Launch]]
"""What writes points and normals of the patches of one level: those of others return at once."""


class Leveled(DeviceSubject):
    """Patches of different levels under any system.

    Attributes:
        count: of patches.
        finest: the finest level.
        controls, levels, offsets: of the patches on the device, for the system's launches.
        positions, normals: of the output.

    Raises:
        ValueError: as many `levels` as there are not patches, more vertices than 32-bit indices can name, or a
            coordinate that the sums cannot bear.
        Unsupported: the output does not fit the device's memory.
    """

    def __init__(
        self,
        device: Device,
        patches: BezierPatches,
        params: LeveledParams,
        arrangement: Callable[[int], Arrangement],
        launches: Launches,
    ) -> None:
        super().__init__(device)
        self._patches, self.params = patches, params
        self.count, self.finest = len(patches.points), params.finest
        self._given = params.levels is not None
        if params.levels is not None and len(params.levels) != self.count:
            raise ValueError(
                f"levels: expected one for each of {self.count} patches, got {len(params.levels)}"
            )
        check_size(patches.points)
        with self.setup.host("borders"):
            self._borders = borders.borders_of(patches.points)
            self._arrangements = [arrangement(level) for level in range(self.finest + 1)]
        self._room()
        self._upload()
        self._seen: View | None = None
        with self.setup.host("build"):
            program = device.build("bezier/levels.cl", defines=self.defines)
        self._choosing = self._choose(program)
        if self.count:
            for counts, offsets, total in zip(
                self._sizes, self._offsets, self._totals, strict=True
            ):
                with self.holding("scratch"):
                    scan = ExclusiveScan(device, counts, offsets, total, stage="scan")
                self.add(scan, stage="scan")
            with self.setup.host("build"):
                for level in range(self.finest + 1):
                    for launch in launches(self, level):
                        self.add(launch)
            self._join(program)
        self.warm_up()

    @property
    def defines(self) -> dict[str, int]:
        """Constants of kernels that write part of the output."""
        return {"NORMALS": int(self.params.normals), "STREAMING": 0}

    def _room(self) -> None:
        """Room for all patches at their finest."""
        slots = [len(one.places) for one in self._arrangements]
        levels = self.params.levels
        most = [slots[level] for level in levels] if levels else [slots[-1]] * self.count
        vertices = vertex_total(sum(most), 1)
        faces = 2 * sum(4**level for level in levels or [self.finest] * self.count)
        shape = (vertices if self.params.normals else 0, 3)
        self.positions = self.allocate("positions", (vertices, 3), np.float32, "output")
        self.normals = self.allocate("normals", shape, np.float32, "output")
        self._triangles = self.allocate("triangles", (faces, 3), np.uint32, "output")
        self._counts = self.upload("counts", np.zeros(2, np.uint32), role="output")
        surface = DeviceSurface(
            self.positions,
            self.normals if self.params.normals else None,
            self._triangles,
            vertices,
            faces,
            counts=self._counts,
        )
        self.output = (surface,)

    def _upload(self) -> None:
        count, given = self.count, self.params.levels
        with self.setup.host("upload"):
            self.controls = self.upload("controls", control_rows(self._patches.points), np.float32)
            slots = np.array([len(one.places) for one in self._arrangements], np.uint32)
            self._slots = self.upload("slots", slots, role="pattern")
            levels = np.array(given if given else [0] * count, np.int64)
            edges = edge_levels(self._borders, levels)
            self.levels = self.upload("levels", levels.astype(np.uint32), role="scratch")
            self._edges = self.upload("edge_levels", edges.astype(np.uint32), role="scratch")
            sizes = slots[levels], (2 * 4**levels).astype(np.uint32)
            self._sizes = [
                self.upload(f"{name}_counts", size, role="scratch")
                for name, size in zip(("vertex", "triangle"), sizes, strict=True)
            ]
            names = ("vertex", "triangle")
            self._offsets = [
                self.allocate(f"{name}_offsets", max(count, 1), np.uint32) for name in names
            ]
            self._totals = [
                self.upload(f"{n}_total", np.zeros(1, np.uint32), role="scratch") for n in names
            ]

    @property
    def offsets(self) -> Buffer:
        """The first vertex of each patch."""
        return self._offsets[0]

    def _choose(self, program: Any) -> Launch:
        """The first step of a frame; given levels are there already."""
        launch = program.launch(
            "bezier_levels", self.count, stage="levels", local=group_size(self.device), controls=self.controls,
            slots=self._slots, levels=self.levels, edge_levels=self._edges, vertex_counts=self._sizes[0],
            triangle_counts=self._sizes[1], screen_x=(0.0,) * 4, screen_y=(0.0,) * 4, screen_w=(0.0,) * 4,
            pixels=self.params.pixels, finest=self.finest, patch_count=self.count,
        )  # fmt: skip
        if self.count and not self._given:
            self.add(launch, bytes=4 * (CONTROL_FLOATS + 7) * self.count)
        return launch

    def _join(self, program: Any) -> None:
        """Points on borders, normals there, and triangles."""
        places, owners = border_places(self._arrangements), normal_sources(self._borders)
        topology = [one.triangles for one in self._arrangements]
        with self.setup.host("upload"):
            held = {
                name: self.upload(name, values, np.uint32, role="pattern")
                for name, values in {
                    "places": np.concatenate(places).astype(np.uint32),
                    "place_starts": _starts(places),
                    "owners": owners,
                    "topology": np.concatenate(topology),
                    "topology_starts": _starts(topology),
                }.items()
            }
        local = group_size(self.device)
        snap = program.launch(
            "bezier_levels_snap", self.count, stage="snap", local=1, controls=self.controls, levels=self.levels,
            edge_levels=self._edges, offsets=self.offsets, vertex_total=self._totals[0],
            triangle_total=self._totals[1], places=held["places"], place_starts=held["place_starts"],
            owners=held["owners"], positions=self.positions, normals=self.normals, counts=self._counts,
            patch_count=self.count,
        )  # fmt: skip
        self.add(snap)
        chunks = -(-2 * 4**self.finest // INDEX_CHUNK)
        indices = program.launch(
            "bezier_levels_indices", self.count * chunks, stage="indices", local=local, levels=self.levels,
            offsets=self.offsets, triangle_offsets=self._offsets[1], topology=held["topology"],
            topology_starts=held["topology_starts"], triangles=self._triangles, chunks=chunks,
            patch_count=self.count,
        )  # fmt: skip
        self.add(indices, bytes=lambda own: POINT * own.live()[1])

    def steps(self, frame: Frame) -> Sequence[Step]:
        """Levels by the frame's view: without one, all the finest."""
        if frame.view is not self._seen:
            rows = ((0.0,) * 4,) * 3 if frame.view is None else pixel_rows(frame.view)
            x, y, w = rows
            self._choosing.set(screen_x=x, screen_y=y, screen_w=w)
            self._seen = frame.view
        return self._steps

    # afterwards

    def levels_of_last(self) -> tuple[borders.Numbers, borders.Numbers]:
        """Levels of the last frame's patches, (m,), and of their edges, (m, 4)."""
        self.live()
        found = self.device.read_all((self.levels, None), (self._edges, None))
        levels, edges = (values.astype(np.int64) for values in found)
        return levels.ravel(), edges.reshape(-1, 4)

    def vertices(self) -> tuple[borders.Numbers, borders.Numbers, borders.Numbers]:
        """Of every vertex of the last frame its patch and where it stands, i and j on the finest lattice, (n,) each."""
        return snapped_vertices(self._arrangements, *self.levels_of_last())

    def welded(self) -> TriangleMesh:
        """The last frame's mesh with every shared vertex once, and triangles that have come together left out.

        Where patches meet at an angle a vertex has the mean of their normals.
        """
        (mesh,) = self.result()
        patch, i, j = self.vertices()
        side = side_vertices(self.finest)
        number, _ = borders.sharing(self._borders, self.finest)
        key = number[patch, i * side + j]
        _, first, vertex = np.unique(key, return_index=True, return_inverse=True)
        vertex = vertex.reshape(-1).astype(np.uint32)
        triangles = vertex[mesh.triangles]
        a, b, c = triangles.T
        triangles = triangles[(a != b) & (b != c) & (c != a)]
        used = np.zeros(len(first), np.bool_)  # a vertex of a patch that has none left
        used[triangles] = True
        normals = None if mesh.normals is None else shared_normals(mesh.normals, vertex, first)
        renumbered = np.cumsum(used) - 1
        return TriangleMesh(
            mesh.positions[first][used],
            renumbered[triangles].astype(np.uint32),
            None if normals is None else normals[used],
        )

    def check(self) -> Check:
        """Points and normals of some patches at their levels, spread over all, against float64."""
        (mesh,) = self.result()
        return judged(self._patches, self.finest, mesh, *self.vertices())

    def more_counters(self) -> Mapping[str, int | float]:
        """The patches, their levels, and which of their borders are one."""
        levels, _ = self.levels_of_last()
        return {
            "patches": self.count,
            "segments": 1 << self.finest,
            "least_level": int(levels.min(initial=self.finest)),
            "most_level": int(levels.max(initial=0)),
            "mean_level": float(levels.mean()) if len(levels) else 0.0,
            "launches": len(self._steps),
            **self._borders.counts(),
        }


def _starts(parts: Sequence[np.ndarray]) -> np.ndarray:
    return np.cumsum([0, *map(len, parts)]).astype(np.uint32)
