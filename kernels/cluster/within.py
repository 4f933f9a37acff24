"""Where are two surfaces farther apart than a bound, either way?"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.stages.scan import ExclusiveScan, chunk_count, chunk_local

FILES = "cluster/within.cl", "cluster/within_pieces.cl"
ROUNDING = 4e-7  # of the diagonal: what float32 may add to a distance
SIDE = 1.8  # of a cell, in roots of a mean triangle's area
SAFE = 0.99  # of the bound: what corners of the last pieces are held to
FINEST = 0.25  # pieces longer than this, in roots of a mean triangle's area of the other surface, are cut
WHOLE = 1e6  # longer than any edge
MOST_CELLS = 1 << 24

Flags = NDArray[np.bool_]


class Within:
    """A surface that others are compared with; distances are shares of its box's diagonal."""

    def __init__(self, device: Device, mesh: TriangleMesh) -> None:
        """Upload it.

        Args:
            device: where it is compared.
            mesh: with one triangle at least.
        """
        self.device = device
        self._low, self._scale = mesh.box[0], mesh.diagonal or 1.0
        self._own = _Placed(device, mesh, self._low, self._scale)

    def far(self, other: TriangleMesh, bound: float) -> tuple[Flags, Flags]:
        """Triangles of this surface, and of the other, with a point farther from the other surface than `bound`.

        That none is far is certain but for the last pieces (`FINEST`), of which corners are looked at; that one is far
        is so to 1 % (`SAFE`). Where the corners of triangles are far, no more is looked at.

        Args:
            other: with one triangle at least.
            bound: share of the diagonal.
        """
        bound = max(SAFE * bound - ROUNDING, 0.0)
        theirs = _Placed(self.device, other, self._low, self._scale)
        found = [np.zeros(0, bool)] * 2
        for cut in (False, True):
            found = [self._own.far(theirs, bound, cut), theirs.far(self._own, bound, cut)]
            if found[0].any() or found[1].any():
                break
        return found[0], found[1]


class _Placed:
    """A surface in the unit of the diagonal, and the grid over it, made for the first bound that is asked for."""

    def __init__(self, device: Device, mesh: TriangleMesh, low: np.ndarray, scale: float) -> None:
        self.device, self.count = device, mesh.triangle_count
        points = (mesh.positions.astype(np.float64) - low) / scale
        a, b, c = (points[mesh.triangles[:, k]] for k in range(3))
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1).mean() / 2
        self.size = max(math.sqrt(area), 1e-6)
        # the other surface may reach beyond the box by its distance from this one
        self.low, self.high = np.minimum(points.min(axis=0), 0), points.max(axis=0)
        self.points = device.upload("points", points.astype(np.float32))
        self.triangles = device.upload("triangles", mesh.triangles)
        self.program = device.build(*FILES)
        self.chunks = chunk_count(device, self.count)
        self._grid: dict[str, object] | None = None

    def _launch(self, kernel: str, **arguments: object) -> None:
        self.program.launch(
            f"cluster_within_{kernel}", self.chunks, stage="within", local=chunk_local(self.device),
            points=self.points, triangles=self.triangles, triangle_count=self.count,
            chunk_count=self.chunks, **arguments,
        )(Timeline())  # fmt: skip

    def grid(self, bound: float) -> dict[str, object]:
        """What the kernel asks of the surface that is searched."""
        if self._grid is None:
            self._grid = self._made(bound)
        return self._grid

    def _made(self, bound: float) -> dict[str, object]:
        device, extents = self.device, np.maximum(self.high, 1e-6)
        most = min(4 * self.count + 4096, MOST_CELLS)
        side = max(SIDE * self.size, bound, float(extents.max()) / 1000)
        while np.prod(np.ceil(extents / side)) > most:
            side *= 1.25
        sides = np.ceil(extents / side).astype(int)
        cells, total = (device.allocate("cells", int(n), np.uint32) for n in (sides.prod(), 1))
        device.fill(Timeline(), "within", cells, 0)
        shared = {"along": 1 / side, "sides": tuple(map(int, sides))}
        self._launch("count", cells=cells, **shared)
        ExclusiveScan(device, cells, cells, total)(Timeline())
        listed = device.allocate("list", int(device.read(total)[0]), np.uint32)
        self._launch("fill", cells=cells, list=listed, **shared)
        return {
            "others": self.points, "other_triangles": self.triangles, "cells": cells,
            "list": listed, **shared,
        }  # fmt: skip

    def far(self, other: _Placed, bound: float, cut: bool) -> Flags:
        """Which triangles have a point farther from the other surface? Corners alone where nothing is `cut`."""
        least = FINEST * min(self.size, other.size) if cut else WHOLE
        far = self.device.allocate("far", self.count, np.uint8)
        self._launch("pieces", far=far, bound=bound, least=least, **other.grid(bound))
        return self.device.read(far) > 0
