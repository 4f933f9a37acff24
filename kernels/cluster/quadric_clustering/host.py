"""Quadric vertex clustering on a device: upload, size, and the launches of a frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.cluster.quadric_clustering.judge import judge
from lodbench.kernels.cluster.quadric_clustering.params import Params
from lodbench.kernels.cluster.quadric_clustering.passes import Passes
from lodbench.kernels.cluster.quadric_clustering.reference import KINDS, simplify
from lodbench.kernels.cluster.quadric_clustering.upload import Upload
from lodbench.kernels.cluster.search import Found, find_cells
from lodbench.kernels.cluster.survivors import DeviceSurvivors
from lodbench.kernels.cluster.unchanged import Unchanged, without_duplicates
from lodbench.kernels.device import Device, DeviceError
from lodbench.kernels.stages.timeline import Timeline
from lodbench.kernels.system import Check, DeviceSurface, Footprint, Frame, Traffic
from lodbench.kernels.targets import missed

# launches that this device has compiled; a second subject need not run a frame to warm them
_warm: WeakKeyDictionary[Device, set[tuple[Any, ...]]] = WeakKeyDictionary()


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> QuadricClustering | Unchanged:
    """The mesh uploaded, the grid found where a number of triangles is asked for, and a frame ready to run.

    Where all triangles are asked for, or no grid comes nearer, the mesh itself is the result. With a target, `setup`
    has the stage "search".

    Raises:
        ValueError: more than 2**27 cells.
        Unsupported: no room, or no 64-bit atomics where fixed_point asks for them.
    """
    upload = Upload(device, mesh)
    asked = params.triangles(mesh.triangle_count)
    if asked is None:
        return QuadricClustering(upload, params)
    found = search_cells(upload, asked, params.remove_duplicates)
    if found.cells is not None:
        params = replace(params, target_reduction=None, target_count=None, cells=found.cells)
        return QuadricClustering(upload, params, found)
    kept = upload
    if params.remove_duplicates:
        kept = Upload(device, without_duplicates(mesh))
        upload.setup.stage_s |= kept.setup.stage_s
    counters = {
        "vertices_in": mesh.vertex_count, "triangles_in": mesh.triangle_count,
        "counting_passes": found.counts, **missed(asked, kept.mesh.triangle_count),
    }  # fmt: skip
    return Unchanged(device, kept.mesh, kept.positions, kept.triangles, upload.setup, counters)


def search_cells(upload: Upload, target_count: int, remove_duplicates: bool = False) -> Found:
    """The grid that leaves at most `target_count` triangles, as `find_cells` says; seconds go to the stage "search"."""
    with upload.setup.host("search"):
        count = DeviceSurvivors(
            upload.device, upload.program, upload.positions, upload.triangles,
            (upload.low, upload.high), remove_duplicates,
        )  # fmt: skip
        return find_cells(count, upload.high - upload.low, upload.mesh.triangle_count, target_count)


class QuadricClustering:
    """One mesh, one grid: `enqueue` leaves the simplified mesh in `output`; `found` says how a search got there."""

    def __init__(self, upload: Upload, params: Params, found: Found | None = None) -> None:
        device = self._device = upload.device
        self._upload = upload
        self.params = params
        self._found = found
        self.setup = upload.setup
        self.grid = Grid.over(upload.low, upload.high, params.grid_cells)
        self._ran = False
        before = device.used_bytes
        passes = self._passes = Passes(upload, self.grid, params)
        self._scratch = device.used_bytes - before - self._output_bytes()
        key = (passes.private, passes.fused, params.remove_duplicates)
        warm = _warm.setdefault(device, set())
        self.setup.from_cache["first_launch"] = key in warm
        if key not in warm:
            with self.setup.host("first_launch"):
                self.enqueue(Frame(), Timeline())
                device.wait()
            warm.add(key)

    @property
    def output(self) -> DeviceSurface:
        """The last frame's mesh; as many vertices as occupied cells and triangles as the input at most."""
        return DeviceSurface(
            positions=self._passes.vertices_out,
            normals=None,
            triangles=self._passes.survivors,
            vertex_count=self._passes.capacity,
            triangle_count=self._upload.mesh.triangle_count,
            counts=self._passes.counts,
        )

    def enqueue(self, frame: Frame, timeline: Timeline) -> None:
        """All passes; never waits. The input is the same each frame."""
        self._ran = True
        for step in self._passes.steps:
            step(timeline)

    def _live(self) -> tuple[int, int]:
        """Output vertices and triangles of the last frame; one is run when there was none."""
        if not self._ran:
            self.enqueue(Frame(), Timeline())
        occupied = int(self._device.read(self._passes.state)[0])
        if occupied > self._passes.capacity:
            raise DeviceError(
                f"cells: expected {self._passes.capacity} occupied as in set-up, got {occupied}"
            )
        vertices, triangles = self._device.read(self._passes.counts)
        return int(vertices), int(triangles)

    def result(self) -> Sequence[TriangleMesh]:
        """The simplified mesh, without normals."""
        vertices, triangles = self._live()
        return [
            TriangleMesh(
                self._device.read(self._passes.vertices_out, vertices),
                self._device.read(self._passes.survivors, triangles),
            )
        ]

    def vertex_map(self) -> NDArray[np.uint32]:
        """The last frame's output vertex of each input vertex, (n,); 0xFFFFFFFF where its cell has none."""
        result = self._device.allocate("vertex_map", self._upload.mesh.vertex_count, np.uint32)
        self._passes.launch(
            "vertex_map", self._upload.mesh.vertex_count, "vertex_map",
            points=self._passes.points, new_ranks=self._passes.new_ranks, vertex_map=result,
            vertex_count=self._upload.mesh.vertex_count,
        )(Timeline())  # fmt: skip
        return self._device.read(result)

    def check(self) -> Check:
        """Same triangles as the reference, and each representative as deep in its planes, in cells."""
        return judge(self.result()[0], simplify(self._upload.mesh, self.params))

    def counters(self) -> Mapping[str, int | float]:
        """Sizes in and out, occupied cells, and how the used cells' representatives were placed.

        With a target also `target`, `target_gap` (triangles short of it, negative where there are more),
        `counting_passes` and `cells_along_longest`.
        """
        vertices, triangles = self._live()
        solved = self._device.read(self._passes.solved, self._passes.occupied)[:, 3]
        placed = np.bincount(solved.astype(np.int64), minlength=len(KINDS) + 1)[1:]
        found: dict[str, int | float] = {}
        if self._found is not None:
            found = missed(self._found.target, triangles)
            found["counting_passes"] = self._found.counts
            found["cells_along_longest"] = self._found.cells or 0.0
        return {
            "vertices": vertices,
            "triangles": triangles,
            "vertices_in": self._upload.mesh.vertex_count,
            "triangles_in": self._upload.mesh.triangle_count,
            "cells": self.grid.cell_count,
            "cells_occupied": self._passes.occupied,
            **{f"placed_{kind}": int(n) for kind, n in zip(KINDS, placed, strict=True)},
            **found,
        }

    def _output_bytes(self) -> int:
        return (
            self._passes.vertices_out.size_bytes
            + self._passes.survivors.size_bytes
            + self._passes.counts.size_bytes
        )

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
        passes, mesh = self._passes, self._upload.mesh
        lanes, out = passes.sums.size_bytes, 12 * triangles
        first = 12 * mesh.vertex_count + 12 * mesh.triangle_count + 32 * mesh.vertex_count + lanes
        # 70 for a plane and its products, 14 sums at each of 3 corners; a solve is about 90
        stages = {
            passes.first: Traffic(first + out * passes.fused, 112 * mesh.triangle_count),
            "pass_2": Traffic(lanes + 12 * vertices, 90 * passes.occupied),
        }
        if not passes.fused:
            stages["pass_3"] = Traffic(12 * mesh.triangle_count + 4 * mesh.vertex_count + out)
        return stages
