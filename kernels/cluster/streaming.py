"""Clustering of a mesh file that need not fit into memory: the passes, each over the file's batches.

What is kept is the cluster map, of the occupied cells; triangles that are left go to a temporary file as ranks of
cells, in the order of the input. The result is that of the same parameters in core, bit for bit.

Source: Lindstrom 2000, Out-of-Core Simplification of Large Polygonal Models; the passes are DeCoro & Tatarchuk's, 2007.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, BinaryIO, TypeVar

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.batches import Batch, MeshFile, ahead
from lodbench.kernels.cluster.batches import CellBatches, kept_of
from lodbench.kernels.cluster.borders import NO_VERTICES
from lodbench.kernels.cluster.borders_stream import FILE, StreamBorders
from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.cluster.search import Found, find_cells
from lodbench.kernels.cluster.upload import SHARED
from lodbench.kernels.cluster.warped import WARPS, WarpedTarget
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.parameters import check
from lodbench.kernels.result import Left, Told
from lodbench.kernels.stages.scan import chunk_count, chunk_local
from lodbench.kernels.targets import missed

P = TypeVar("P", bound=WarpedTarget)
_OF_THE_WHOLE = ("remove_flipped", "manifold")  # what `cluster/finish.py` does
_NO_CELL = np.uint32(0x80000000)  # cells are fewer


def streamer(make: type[CellBatches], params: type[P]) -> Callable[..., Left]:
    """What simplifies files in batches, made of a system's sums and its `Params`.

    Args:
        make: the system's cells, of a device, a grid, params and a number of triangles.
        params: its parameters.
    """

    def simplify_batches(
        device: Device, source: MeshFile, spill: BinaryIO, rows: int, told: Told, **options: Any
    ) -> Left:
        """All passes but the writing.

        Args:
            device: where it runs; its memory limit holds the grid.
            source: the file.
            spill: an empty file for the triangles left.
            rows: triangles of a batch.
            told: called as it goes on.
            **options: those of the Params; and attributes=False, which leaves normals and colours behind.

        Raises:
            TypeError, ValueError: an option is wrong or needs the whole mesh, all triangles are asked for, or a value
                in the file is wrong.
            Unsupported: the device has no room for the grid.
        """
        carried = check("attributes", options.pop("attributes", True), bool)
        for name in _OF_THE_WHOLE:
            if options.pop(name, False):
                raise ValueError(f"{name}: expected False out of core, got True")
        asked = params.named(**options)
        if asked.remove_duplicates:
            raise ValueError("remove_duplicates: expected False out of core, got True")
        if any(getattr(asked, name) for name in WARPS):
            raise ValueError("regions, view, warp: expected none of them out of core, got one")
        if asked.keeps_border and not source.shared:
            raise ValueError(f"{source.path}: expected PLY out of core for border='keep', got STL")
        if source.vertex_count and not source.triangle_count:
            raise ValueError(
                f"faces: expected triangles, got {source.vertex_count:,} points and none"
            )
        if make.SHARED_ONLY and not source.shared:
            raise ValueError(
                f"{source.path}: expected PLY out of core for means of points, got STL"
            )
        return _passes(device, source, spill, rows, told, asked, make, carried)

    return simplify_batches


def _passes(
    device: Device,
    source: MeshFile,
    spill: BinaryIO,
    rows: int,
    told: Told,
    params: Any,
    make: type[CellBatches],
    carried: bool,
) -> Left:
    count = source.triangle_count
    target = params.triangles(count)
    weights = {"box": 1.0, "borders": 5.0, "search": 12.0, "cells": 1.5}
    weights |= make.weights(device, params) | {"write": 1.0}
    left_out = {"borders": not params.uses_border, "search": target is None}
    tell = _Shares(told, {name: w for name, w in weights.items() if not left_out.get(name)})
    tell("box", 0.0)
    box = source.box(lambda share: tell("box", share))
    borders, kept = None, NO_VERTICES
    if params.uses_border:
        borders = StreamBorders(device, source, rows, lambda share: tell("borders", share))
        kept = borders.vertices() if params.keeps_border else NO_VERTICES
    found: Found | None = None
    if target is not None:
        counting = StreamSurvivors(
            device, source, box, rows, lambda share: tell("search", share), kept
        )
        found = find_cells(counting, box[1] - box[0], count, target)
        if found.cells is None:
            raise ValueError(
                f"target_count: expected a grid that leaves some of the {count:,} triangles out of core, "
                f"got {target:,}: none does"
            )
        params = replace(params, target_reduction=None, target_count=None, cells=found.cells)
    grid = Grid.over(*box, params.grid_cells)
    work = make(device, grid, params, count)
    done = 0
    for positions in ahead(source.positions()):
        work.mark(positions)
        tell("cells", (done := done + len(positions)) / source.vertex_count)
    work.rank(kept)
    source.carried = source.attributes if carried else ()
    left = work.walk(source, rows, None if params.keeps_border else borders, spill, tell)
    vertices, new_ranks = work.solve(source)
    counters: dict[str, int | float] = {
        "vertices": len(vertices),
        "triangles": left,
        "vertices_in": source.vertex_count,
        "triangles_in": count,
        "cells": grid.cell_count,
        **{f"cells_{axis}": n for axis, n in zip("xyz", grid.counts, strict=True)},
        "cells_occupied": work.occupied,
        "border_edges": borders.count if borders else 0,
    }
    if found is not None:
        counters |= {**missed(found.target, left), "counting_passes": found.counts}
        counters["cells_along_longest"] = found.cells or 0.0
    attributes = work.attributes(new_ranks)
    return Left(vertices, source.origin, new_ranks, left, counters, attributes)


class StreamSurvivors:
    """Counting passes over a file, as `survivors.DeviceSurvivors` counts over a mesh in device memory."""

    def __init__(
        self,
        device: Device,
        source: MeshFile,
        box: tuple[NDArray[np.float64], NDArray[np.float64]],
        rows: int,
        told: Callable[[float], None] = lambda share: None,
        kept: NDArray[np.uint32] = NO_VERTICES,
    ) -> None:
        """Nothing is read yet.

        Args:
            device: where it is counted.
            source: the file.
            box: of all its points.
            rows: triangles of a batch.
            told: called with a share of the passes done, of which nobody knows how many there will be.
            kept: rows of vertices that are in no cell but stay by themselves.
        """
        self._device, self._source, self._box, self._rows, self._told = (
            device, source, box, rows, told,
        )  # fmt: skip
        self._programs = [device.build(*SHARED)]
        self._kept = kept
        if len(kept):
            self._programs.append(device.build(FILE))
        self._samples: dict[int, Batch] = {}
        self._passes = 0

    def __call__(self, cells: float, stride: int = 1) -> int:
        """Of every `stride`-th triangle those that the grid of `cells` leaves."""
        grid, count = Grid.over(*self._box, cells).arguments, self._source.triangle_count
        if stride > 1:
            if stride not in self._samples:
                self._samples[stride] = joined(
                    list(self._source.batches(0, count, self._rows, stride))
                )
            return self._left(self._samples[stride], grid)
        total = done = 0
        for batch in ahead(self._source.batches(0, count, self._rows)):
            total += self._left(batch, grid)
            done += len(batch.triangles)
            self._told(1 - 0.75 ** (self._passes + done / count))
        self._passes += 1
        return total

    def _left(self, batch: Batch, grid: dict[str, Any]) -> int:
        device, positions, triangles, vertices = self._device, *batch[:3]
        ids = device.allocate("cell_ids", len(positions), np.uint32)
        self._launch(
            "cluster_search_cells", len(positions), positions=device.upload("positions", positions),
            cell_ids=ids, vertex_count=len(positions), **grid,
        )  # fmt: skip
        rows, numbers = kept_of(self._kept, vertices, len(positions))
        if len(rows):
            self._launch(
                "cluster_borders_batch_keep_ids", len(rows), kept_rows=device.upload("kept_rows", rows),
                ranks=device.upload("ranks", numbers + _NO_CELL), cell_ids=ids, kept_count=len(rows),
            )  # fmt: skip
        left = device.allocate("survivors", chunk_count(device, len(triangles)), np.uint32)
        self._launch(
            "cluster_search_survivors", len(triangles), cell_ids=ids, survivors=left, stride=1,
            triangles=device.upload("triangles", triangles), sample_count=len(triangles),
        )  # fmt: skip
        return int(device.read(left).sum(dtype=np.int64))

    def _launch(self, kernel: str, rows: int, **arguments: Any) -> None:
        chunks = chunk_count(self._device, rows)
        next(program for program in self._programs if kernel in program.kernels).launch(
            kernel, chunks, stage="search", local=chunk_local(self._device), chunk_count=chunks, **arguments,
        )(Timeline())  # fmt: skip


def joined(batches: list[Batch]) -> Batch:
    """Batches as one."""
    starts = np.cumsum([0, *(len(batch.positions) for batch in batches)])
    triangles = [b.triangles + np.uint32(s) for b, s in zip(batches, starts, strict=False)]
    vertices = [
        b.vertices + np.arange(len(b.positions)) if isinstance(b.vertices, int) else b.vertices
        for b in batches
    ]
    positions = np.concatenate([b.positions for b in batches])
    return Batch(positions, np.concatenate(triangles), np.concatenate(vertices))


class _Shares:
    """Shares of passes as one share of the whole."""

    def __init__(self, told: Told, weights: Mapping[str, float]) -> None:
        self._told = told
        starts = np.cumsum([0.0, *weights.values()]) / sum(weights.values())
        self._span = {name: (starts[i], starts[i + 1]) for i, name in enumerate(weights)}

    def __call__(self, name: str, share: float) -> None:
        low, high = self._span[name]
        self._told(name, float(low + (high - low) * min(share, 1.0)))
