"""A mesh on the device with its box: uploaded once, then simplified with any number of grids."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Indices, TriangleMesh
from lodbench.kernels.cluster import warp as warps
from lodbench.kernels.cluster.borders import border_edges
from lodbench.kernels.cluster.warp import Warp
from lodbench.kernels.opencl import Buffer, Device, Launch, Timeline
from lodbench.kernels.stages.scan import chunk_count, chunk_local

# built as one program with a system's own: a build reads the driver's headers and the prelude anew, most of its time
SHARED = tuple(
    f"cluster/{name}.cl" for name in ("box", "cells", "compact", "emit", "search", "borders")
)


class Upload:
    """Positions and triangles in device memory.

    Attributes:
        mesh: the mesh as it came.
        program: the kernels that all clusterings share, and the system's own.
        positions: float32, (n, 3).
        triangles: uint32, (m, 3).
        low, high: the box of all positions, (3,) float64; zeros when there are none.
        setup: seconds of the upload, and of what is made from it later.
        warp: where the grid's cells are not to be alike, else None.
        placed: positions in the grid's space, float32, (n, 3): without a warp those of the mesh.
        box: that of `placed`, lower and upper corner, (3,) float64 each.
        warping: fills `placed` and `stretch`, of the warp at each vertex, float32, (n, 3); None without a warp.
    """

    def __init__(
        self,
        device: Device,
        mesh: TriangleMesh,
        files: Sequence[str] = (),
        warp: Warp | None = None,
    ) -> None:
        self.device = device
        self.mesh = mesh
        self.setup = Timeline()
        with self.setup.host("upload"):
            self.positions = device.upload(
                "positions", mesh.positions, np.float32, (None, 3), wait=False
            )
            self.triangles = device.upload(
                "triangles", mesh.triangles, np.uint32, (None, 3), wait=False
            )
        with self.setup.host("build"):
            if warp is None:
                self.program = device.build(*files, *SHARED)
            else:
                self.program = device.build(*files, *SHARED, warps.FILE, defines=warps.DEFINES)
        with self.setup.host("box"):
            self.low, self.high = self.box = self._box(self.positions)
        self.warp, self.placed = warp, self.positions
        self.warping: Launch | None = None
        if warp is not None:
            with self.setup.host("warp"):
                self._prepare_warp(warp)

    def _box(self, positions: Buffer) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lower and upper corner."""
        if not self.mesh.vertex_count:
            return np.zeros(3), np.zeros(3)
        device, chunks = self.device, chunk_count(self.device, self.mesh.vertex_count)
        boxes = device.allocate("boxes", (chunks, 2, 3, 8), np.float32)
        box = self.program.launch(
            "cluster_box", chunks, stage="box", local=chunk_local(device),
            positions=positions, boxes=boxes,
            vertex_count=self.mesh.vertex_count, chunk_count=chunks,
        )  # fmt: skip
        box(Timeline())
        found = device.read(boxes).astype(np.float64)
        return found[:, 0].min((0, 2)), found[:, 1].max((0, 2))

    def _prepare_warp(self, warp: Warp) -> None:
        device, count = self.device, self.mesh.vertex_count
        chunks = chunk_count(device, count)
        self.placed = device.allocate("warped", (count, 3), np.float32)
        self.stretch = device.allocate("stretch", (count, 3), np.float32)
        tables = {name: device.upload(name, values) for name, values in warp.tables.items()}
        self.warping = self.program.launch(
            warp.kernel, chunks, stage="pass_1", local=chunk_local(device),
            positions=self.positions, warped=self.placed, stretch=self.stretch,
            vertex_count=count, chunk_count=chunks, **tables, **warp.arguments,
        )  # fmt: skip
        self.warping(Timeline())
        self.box = self._box(self.placed)

    @cached_property
    def border_edges(self) -> Indices:
        """See `borders.border_edges`; found once, in the set-up stage "borders"."""
        with self.setup.host("borders"):
            return border_edges(self.device, self.program, self.triangles, self.mesh.positions)
