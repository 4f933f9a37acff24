"""A mesh on the device with its box: uploaded once, then simplified with any number of grids."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Indices, TriangleMesh
from lodbench.kernels.cluster import warp as warps
from lodbench.kernels.cluster.borders import NO_EDGES, border_edges, cancel
from lodbench.kernels.cluster.warp import Warp
from lodbench.kernels.opencl import Buffer, Device, Launch, Timeline
from lodbench.kernels.stages.scan import chunk_count, chunk_local

# built as one program with a system's own: a build reads the driver's headers and the prelude anew, most of its time
SHARED = tuple(
    f"cluster/{name}.cl" for name in ("look", "cells", "compact", "emit", "search", "borders_keep")
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
        borders: bool = False,
    ) -> None:
        """Upload, and look at all of it once.

        Args:
            device: where to.
            mesh: whose arrays must stay as they are meanwhile: a CPU reads them where they lie.
            files: the system's own kernels.
            warp: see `Upload`.
            borders: will `border_edges` be asked for? A closed mesh is then told in the same look.
        """
        self.device = device
        self.mesh = mesh
        self.setup = Timeline()
        with self.setup.host("upload"):
            self.positions = device.upload(
                "positions", mesh.positions, np.float32, (None, 3), lent=True
            )
            self.triangles = device.upload(
                "triangles", mesh.triangles, np.uint32, (None, 3), lent=True
            )
        with self.setup.host("build"):
            if warp is None:
                self.program = device.build(*files, *SHARED)
            else:
                self.program = device.build(*files, *SHARED, warps.FILE, defines=warps.DEFINES)
        with self.setup.host("box"):
            looks = (
                self._looks() if borders and mesh.vertex_count else [self._boxes(self.positions)]
            )
            boxes, *sums = device.read_all(*((look, None) for look in looks))
            self._closed = not mesh.triangle_count or (bool(sums) and cancel(sums[0]))
            self.low, self.high = self.box = _box(boxes)
        self.warp, self.placed = warp, self.positions
        self.warping: Launch | None = None
        if warp is not None:
            with self.setup.host("warp"):
                self._prepare_warp(warp)

    def _looks(self) -> list[Buffer]:
        """What `_boxes` gives of the mesh, and `edge_sums` of its triangles, from one launch; never waits."""
        device, vertices, triangles = self.device, self.mesh.vertex_count, self.mesh.triangle_count
        chunks = chunk_count(device, max(vertices, triangles))
        boxes = device.allocate("boxes", (chunks, 2, 3, 8), np.float32)
        sums = device.allocate("sums", (chunks, 2), np.uint32)
        self.program.launch(
            "cluster_look", chunks, stage="box", local=chunk_local(device),
            positions=self.positions, triangles=self.triangles, boxes=boxes, sums=sums,
            vertex_count=vertices, triangle_count=triangles, chunk_count=chunks,
        )(Timeline())  # fmt: skip
        return [boxes, sums]

    def _boxes(self, positions: Buffer) -> Buffer:
        """Corners of boxes that together hold all positions, (boxes, lower and upper, xyz, 8); never waits."""
        device, count = self.device, self.mesh.vertex_count
        chunks = chunk_count(device, count)
        boxes = device.allocate("boxes", (chunks if count else 0, 2, 3, 8), np.float32)
        if count:
            self.program.launch(
                "cluster_box", chunks, stage="box", local=chunk_local(device),
                positions=positions, boxes=boxes, vertex_count=count, chunk_count=chunks,
            )(Timeline())  # fmt: skip
        return boxes

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
        self.box = _box(device.read(self._boxes(self.placed)))

    @cached_property
    def border_edges(self) -> Indices:
        """See `borders.border_edges`; found once, in the set-up stage "borders"."""
        if self._closed:
            return NO_EDGES
        with self.setup.host("borders"):
            return border_edges(self.device, self.program, self.triangles, self.mesh.positions)


def _box(boxes: NDArray[np.float32]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lower and upper corner of what `Upload._boxes` gives; zeros of nothing."""
    if not len(boxes):
        return np.zeros(3), np.zeros(3)
    low, high = boxes[:, 0].min((0, 2)), boxes[:, 1].max((0, 2))
    return low.astype(np.float64), high.astype(np.float64)
