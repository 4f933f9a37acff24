"""A mesh that stays as it is: what a clustering gives where all triangles are asked for, or no grid comes nearer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster import turned
from lodbench.kernels.opencl import Buffer, Device, Timeline
from lodbench.kernels.subject import DeviceSubject
from lodbench.kernels.system import Check, DeviceSurface

STAGE = "copy"


def without_duplicates(mesh: TriangleMesh) -> TriangleMesh:
    """The mesh with the first of each triangles with the same three vertices, whichever way they face, in order."""
    kept = turned.first_of_each(mesh.triangles, mesh.vertex_count)
    edge_tags = None if mesh.edge_tags is None else mesh.edge_tags[kept]
    return replace(mesh, triangles=mesh.triangles[kept], edge_tags=edge_tags)


class Unchanged(DeviceSubject):
    """The identity behind the contract: a frame copies the mesh, points that no triangle uses among them."""

    def __init__(
        self,
        device: Device,
        mesh: TriangleMesh,
        positions: Buffer,
        triangles: Buffer,
        setup: Timeline,
        counters: Mapping[str, int | float],
    ) -> None:
        """Room for the copy.

        Args:
            device: where the mesh is.
            mesh: what comes back, with all that belongs to its vertices.
            positions: float32, (n, 3).
            triangles: uint32, (m, 3).
            setup: what was done so far.
            counters: more of them, by name.
        """
        super().__init__(device, setup)
        self._mesh, self._more = mesh, counters
        self._given = self.hold("input", positions, triangles)
        self._copies = tuple(self.allocate(b.name, b.shape, b.dtype, "output") for b in self._given)
        for source, target in zip(self._given, self._copies, strict=True):
            self._copy(source, target)
        points, faces = self._copies
        self.output = (DeviceSurface(points, None, faces, positions.shape[0], triangles.shape[0]),)

    def _copy(self, source: Buffer, target: Buffer) -> None:
        device = self.device
        self.add(
            lambda timeline: device.copy(timeline, STAGE, source, target),
            bytes=2 * source.size_bytes,
            stage=STAGE,
        )

    def result(self) -> Sequence[TriangleMesh]:
        """The mesh, with its normals, colours and whatever else it had."""
        self.live()
        positions, triangles = (self.device.read(copy) for copy in self._copies)
        return [replace(self._mesh, positions=positions, triangles=triangles)]

    def read_back(self) -> tuple[TriangleMesh, NDArray[np.uint32]]:
        """The mesh, and `vertex_map`."""
        return self.result()[0], self.vertex_map()

    def vertex_map(self) -> NDArray[np.uint32]:
        """Each vertex is its own, (n,)."""
        return np.arange(self._given[0].shape[0], dtype=np.uint32)

    def check(self) -> Check:
        """How many numbers differ from those given."""
        (mesh,) = self.result()
        pairs = zip(self._given, (mesh.positions, mesh.triangles), strict=True)
        wrong = sum(int(np.count_nonzero(self.device.read(b) != values)) for b, values in pairs)
        return Check(wrong == 0, "numbers unlike the input's", wrong, 0)

    def more_counters(self) -> Mapping[str, int | float]:
        """What the search found, and triangles with the vertices of one before them."""
        mesh = self._mesh
        repeated = turned.duplicates(mesh.triangles, mesh.vertex_count)
        return {**self._more, "duplicate_triangles": repeated, "flipped_triangles": 0}
