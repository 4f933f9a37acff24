"""A mesh on the device with its box: uploaded once, then simplified with any number of grids."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from lodbench.datasets_gen.surfaces import Indices, TriangleMesh
from lodbench.kernels.cluster.borders import border_edges
from lodbench.kernels.opencl import Device, Timeline
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
    """

    def __init__(self, device: Device, mesh: TriangleMesh, files: Sequence[str] = ()) -> None:
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
            self.program = device.build(*files, *SHARED)
        with self.setup.host("box"):
            self.low = self.high = np.zeros(3)
            if mesh.vertex_count:
                chunks = chunk_count(device, mesh.vertex_count)
                boxes = device.allocate("boxes", (chunks, 2, 3, 8), np.float32)
                box = self.program.launch(
                    "cluster_box", chunks, stage="box", local=chunk_local(device),
                    positions=self.positions, boxes=boxes,
                    vertex_count=mesh.vertex_count, chunk_count=chunks,
                )  # fmt: skip
                box(Timeline())
                found = device.read(boxes).astype(np.float64)
                self.low, self.high = found[:, 0].min((0, 2)), found[:, 1].max((0, 2))

    @cached_property
    def border_edges(self) -> Indices:
        """See `borders.border_edges`; found once, in the set-up stage "borders"."""
        with self.setup.host("borders"):
            return border_edges(self.device, self.program, self.triangles, self.mesh.vertex_count)
