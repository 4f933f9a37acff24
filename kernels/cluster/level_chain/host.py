"""A chain of levels on a device: quadric clustering, then sums of its cells and triangles of its triangles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster import prepare as family
from lodbench.kernels.cluster.clustering import Clustering
from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.cluster.level_chain.level import Level
from lodbench.kernels.cluster.level_chain.params import Params
from lodbench.kernels.cluster.level_chain.reference import halved
from lodbench.kernels.cluster.level_chain.reference import simplify as reference
from lodbench.kernels.cluster.quadric_clustering.host import FILES as CLUSTERING
from lodbench.kernels.cluster.quadric_clustering.host import (
    PLACEMENTS,
    SUM_LANES,
    QuadricClustering,
)
from lodbench.kernels.cluster.quadric_clustering.verdict import verdict
from lodbench.kernels.cluster.unchanged import Unchanged
from lodbench.kernels.opencl import Device, Launch, Timeline
from lodbench.kernels.result import Result
from lodbench.kernels.stages.scan import chunk_count
from lodbench.kernels.subject import POINT
from lodbench.kernels.system import Check, run

FOLDER = "cluster/level_chain"
FILES = (*CLUSTERING, *(f"{FOLDER}/{name}.cl" for name in ("fragment", "geometry", "serial")))
WORD_ROWS = 16  # a word of 64 cells takes as long as so many of other rows
SERIAL = 2  # chunks of triangles; with so few, launches cost more than a walk by one core


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> Clustering | Unchanged:
    """See `cluster/prepare.py`; a target is the first level's. A mesh that stays as it is has no further levels."""
    return family.prepare(device, mesh, params, LevelChain, FILES)


def simplify(device: Device, mesh: TriangleMesh, **options: Any) -> Result:
    """A chain of simplified meshes, by a number of triangles of the first or by its grid; `options` are the Params'.

    `levels` of the result has all of them, finest first, and `mesh` is the finest. Where all triangles are asked for,
    or no grid comes nearer, the mesh as it came is the only level.
    """
    prepared = prepare(device, mesh, Params.named(**options))
    frame = run(device, prepared)
    levels = tuple(prepared.result())
    maps = prepared.level_maps() if isinstance(prepared, LevelChain) else ()
    counters = dict(prepared.counters())
    return Result(
        levels[0], prepared.vertex_map(), levels, counters, prepared.setup, frame, tuple(maps)
    )


def _cells(finer: Grid, grid: Grid) -> dict[str, tuple[int, ...]]:
    """Cells along each axis, those with one cell last: no cell's number changes, and rows are as long as can be."""
    axes = sorted(range(3), key=lambda axis: finer.counts[axis] == 1)
    counts = [[one.counts[axis] for axis in axes] for one in (finer, grid)]
    return {"fine_cells": (*counts[0], 0), "cells": (*counts[1], grid.cell_count)}


class LevelChain(QuadricClustering):
    """See `lodbench.kernels.cluster.level_chain`; the finest level is what is drawn.

    Attributes:
        levels: all of them, finest first.
    """

    params: Params

    def ready(self, *kernels: Any) -> None:
        """Add the levels after the first; the frame is run level by level, since counts size what comes after."""
        first = Level(
            self.grid, self.occupied, self.words, self.sums, self.new_ranks,
            self.vertices_out, self.survivors, self.counts,
        )  # fmt: skip
        self.levels = [first]
        done = 0
        with self.setup.host("size"):
            for number in range(2, self.params.levels + 1):
                for step in self._steps[done:]:
                    step.enqueue(Timeline())
                done = len(self._steps)
                self.levels.append(self._add_level(self.levels[-1], number))
        super().ready(*kernels, self.params.levels)

    def _add_level(self, finer: Level, number: int) -> Level:
        """The level after `finer`, whose counts are there: room for it, and its steps."""
        stage, grid, allocate = f"level_{number}", halved(finer.grid), self.allocate
        words = allocate("words", (-(-grid.cell_count // 64), 2), np.uint64)
        chunks = chunk_count(self.device, WORD_ROWS * max(words.shape[0], finer.capacity))
        chunk_sums = allocate("chunk_sums", chunks, np.uint32)
        arguments: dict[str, Any] = {
            "fine_words": finer.words, "fine_ranks": finer.new_ranks, "triangles": finer.triangles,
            "fine_counts": finer.counts, "words": words, "chunk_sums": chunk_sums,
            **_cells(finer.grid, grid),
            "fine_word_count": finer.words.shape[0], "word_count": words.shape[0],
            "fine_capacity": finer.capacity,
        }  # fmt: skip
        bits = self._launch(
            "level_chain_fragment_bits", WORD_ROWS * words.shape[0], stage, arguments
        )
        bits(Timeline())
        occupied = int(self.device.read(chunk_sums, bits.items[0]).sum(dtype=np.int64))
        capacity = max(occupied, 1)
        _, triangles = finer.size(self.device.read)

        shape = (1, capacity, 16) if self.floats else (capacity, SUM_LANES)
        level = Level(
            grid, occupied, words,
            allocate("sums", shape, self.sums.dtype),
            allocate("new_ranks", capacity, np.uint32),
            allocate("vertices", (capacity, 3), np.float32, "output"),
            allocate("triangles", (triangles, 3), np.uint32, "output"),
            allocate("counts", 2, np.uint32, "output"),
            allocate("parents", finer.capacity, np.uint32),
        )  # fmt: skip
        joined = level.triangles
        if self.params.remove_duplicates:
            joined = allocate("joined", joined.shape, np.uint32)
        arguments |= {
            "parents": level.parents, "new_ranks": level.new_ranks, "vertices": level.vertices,
            "survivors": joined, "counts": level.counts,
            "state": allocate("state", 4, np.uint32),
            "solved": allocate("solved", (capacity, 4), np.float32),
            "pieces": allocate("pieces", (triangles, 3), np.uint32),
            "piece_counts": allocate("piece_counts", chunk_count(self.device, triangles), np.uint32),
            "placement": PLACEMENTS[self.params.placement],
            "per_box": 1 / grid.extent if grid.extent else 1.0, "limits": self.limits,
            "low": (*grid.low, 0), "to_model": (grid.unit, 1 / grid.prescale),
            "capacity": capacity, "triangle_capacity": triangles,
        }  # fmt: skip
        if self.floats:
            fine_maps = finer.sums.shape[0]
            arguments |= {"fine_maps": finer.sums, "fine_map_count": fine_maps, "maps": level.sums}
        else:
            # in the units of this level areas, areas times lengths and lengths are smaller
            units = (0.25, 0.125, 0.5)
            inverse = (u ** (number - 1) / s for u, s in zip(units, self._scale, strict=True))
            arguments |= {"fine_sums": finer.sums, "sums": level.sums}
            arguments["inverse_scale"] = (*inverse, 0)
        self._add_steps(stage, arguments, triangles)
        if joined is not level.triangles:
            counts = self.remove_duplicates(joined, level.triangles, level.counts, stage)
            level = replace(level, counts=counts)
        return level

    def _add_steps(self, stage: str, arguments: Mapping[str, Any], triangles: int) -> None:
        """A level's walk: over words, the triangles, the level's cells, and the triangles again."""
        sums = arguments["maps" if self.floats else "sums"].size_bytes
        moved = sums + POINT * (triangles + arguments["capacity"])
        few = chunk_count(self.device, triangles) <= SERIAL
        if self.floats and self.device.is_cpu and few:
            launch = self.program("level_chain_serial").launch(
                "level_chain_serial", 1, stage=stage, local=1,
                **self._of("level_chain_serial", arguments),
            )  # fmt: skip
            self.add(launch, bytes=moved)
            return
        kind = "" if self.floats else "_fixed_point"
        words, cells = WORD_ROWS * arguments["word_count"], arguments["capacity"]
        launches = [
            self._launch(kernel, rows, stage, arguments)
            for kernel, rows in (
                ("level_chain_fragment_bits", words),
                (f"level_chain_fragment_downsample{kind}", words),
                (f"level_chain_geometry_decimate{kind}", triangles),
                (f"quadric_clustering_fragment_solve{kind}", cells),
                ("cluster_compact", cells),
                ("level_chain_geometry_join", triangles),
            )
        ]
        for launch in launches[:-1]:
            self.add(launch)
        self.add(launches[-1], bytes=moved)

    def _of(self, kernel: str, arguments: Mapping[str, Any]) -> dict[str, Any]:
        """Those of the arguments that the kernel has."""
        named = (parameter.name for parameter in self.program(kernel).kernels[kernel])
        known = {"map_count": 1, **arguments}  # of a level after the first
        return {name: known[name] for name in named if name in known}

    def _launch(self, kernel: str, rows: int, stage: str, arguments: Mapping[str, Any]) -> Launch:
        """`launch` with those of the arguments that the kernel has."""
        return self.launch(kernel, rows, stage, **self._of(kernel, arguments))

    # afterwards

    def result(self) -> Sequence[TriangleMesh]:
        """The last frame's levels, read back, finest first."""
        self.live()
        return [level.mesh(self.device.read) for level in self.levels]

    def level_maps(self) -> list[NDArray[np.uint32]]:
        """From each level but the last: the next one's vertex for each of its own; 0xFFFFFFFF where there is none."""
        self.live()
        pairs = zip(self.levels, self.levels[1:], strict=False)
        return [coarser.map_from(finer, self.device.read) for finer, coarser in pairs]

    def check(self) -> Check:
        """Each level has the triangles of the mesh clustered on its grid, and representatives as deep in its planes."""
        levels = zip(self.result(), reference(self._mesh, self.params), strict=True)
        checks = [verdict(mesh, expected) for mesh, expected in levels]
        failed = [check for check in checks if not check.passed]
        return failed[0] if failed else max(checks, key=lambda check: check.value / check.tolerance)

    def more_counters(self) -> Mapping[str, int | float]:
        """As of quadric clustering for the first level; cells, vertices and triangles of the others by their number."""
        counters = {**super().more_counters(), "level_count": len(self.levels)}
        for number, level in enumerate(self.levels[1:], 2):
            vertices, triangles = level.size(self.device.read)
            counters |= {
                f"level_{number}_cells_occupied": level.occupied,
                f"level_{number}_vertices": vertices,
                f"level_{number}_triangles": triangles,
            }
        return counters
