"""Sums of vertices per cell, their means, and what all clusterings do."""

from __future__ import annotations

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster import prepare as family
from lodbench.kernels.cluster.clustering import Clustering
from lodbench.kernels.cluster.search import Found
from lodbench.kernels.cluster.unchanged import Unchanged
from lodbench.kernels.cluster.upload import Upload
from lodbench.kernels.cluster.vertex_average.params import Params
from lodbench.kernels.cluster.vertex_average.reference import simplify
from lodbench.kernels.opencl import Device
from lodbench.kernels.system import Check

FILES = ("cluster/vertex_average/mean.cl",)
TOLERANCE = (
    1e-4  # cells: compensated sums in float32, up to some hundred cells from the box's corner
)


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> Clustering | Unchanged:
    """See `cluster/prepare.py`."""
    return family.prepare(device, mesh, params, VertexAverage, FILES)


class VertexAverage(Clustering):
    """See `lodbench.kernels.cluster.vertex_average`."""

    params: Params  # pyright: ignore[reportIncompatibleVariableOverride]

    def __init__(self, upload: Upload, params: Params, found: Found | None) -> None:
        super().__init__(upload, params, found)
        chunks, vertices, triangles = params.chunks, self._vertices, self._triangles
        with self.setup.host("size"):
            self.find_cells("pass_1")
        capacity = self.capacity
        maps = self.allocate("maps", (chunks, capacity, 8), np.float32)
        name = "vertex_average_mean_sum"
        walk = self.program(name).launch(
            name, chunks, stage="pass_1", local=1, points=self.points, maps=maps,
            vertex_count=vertices, capacity=capacity, map_count=chunks,
        )  # fmt: skip
        self.add(walk, bytes=self.points.size_bytes + maps.size_bytes, flops=12 * vertices)
        used = self.allocate("used", capacity, np.uint8)
        self.fill("pass_1", used, 0)
        mark = self.launch(
            "cluster_emit_mark", triangles, "pass_1", points=self.points,
            triangles=upload.triangles, used=used, triangle_count=triangles,
        )  # fmt: skip
        self.add(mark, bytes=12 * triangles + 4 * vertices)
        mean = self.launch(
            "vertex_average_mean_place", capacity, "pass_2", maps=maps, used=used,
            state=self.state, solved=self.solved, chunk_sums=self.chunk_sums,
            map_count=chunks, capacity=capacity,
        )  # fmt: skip
        self.add(mean, bytes=maps.size_bytes + capacity, flops=4 * chunks * self.occupied)
        self.compact("pass_2")
        self.emit("pass_3", params.remove_duplicates)
        self.ready(params.remove_duplicates)

    def check(self) -> Check:
        """Same triangles as the reference, and each vertex where it has it, in cells."""
        (mesh,) = self.result()
        expected = simplify(self._mesh, self.params, self._upload.warp)
        what = "vertices off the reference's, cells; infinity where triangles differ"
        if not np.array_equal(mesh.triangles, expected.triangles):
            return Check(False, what, np.inf, TOLERANCE)
        off = mesh.positions.astype(np.float64) - expected.positions.astype(np.float64)
        worst = float(np.abs(off).max(initial=0)) / self.grid.edge
        tolerance = TOLERANCE + self.grid.rounding(expected.positions)
        return Check(worst <= tolerance, what, worst, tolerance)
