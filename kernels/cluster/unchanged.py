"""A mesh that stays as it is: what a clustering gives where all triangles are asked for, or no grid comes nearer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.device import Buffer, Device
from lodbench.kernels.stages.timeline import Timeline
from lodbench.kernels.system import Check, DeviceSurface, Footprint, Frame, Traffic

STAGE = "copy"


def without_duplicates(mesh: TriangleMesh) -> TriangleMesh:
    """The mesh with the first of each triangles with the same three vertices, whichever way they face, in order."""
    keys = np.sort(mesh.triangles, axis=1)
    _, first = np.unique(keys, axis=0, return_index=True)
    return replace(mesh, triangles=mesh.triangles[np.sort(first)])


class Unchanged:
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
        self.setup = setup
        self._device, self._mesh, self._more = device, mesh, counters
        self._given = (positions, triangles)
        self._copies = tuple(device.allocate(b.name, b.shape, b.dtype) for b in self._given)
        self._ran = False

    @property
    def output(self) -> DeviceSurface:
        """The copy."""
        positions, triangles = self._copies
        return DeviceSurface(positions, None, triangles, positions.shape[0], triangles.shape[0])

    def enqueue(self, frame: Frame, timeline: Timeline) -> None:
        """Copy; never waits."""
        self._ran = True
        for source, target in zip(self._given, self._copies, strict=True):
            self._device.copy(timeline, STAGE, source, target)

    def result(self) -> Sequence[TriangleMesh]:
        """The mesh, with its normals, colours and whatever else it had."""
        if not self._ran:
            self.enqueue(Frame(), Timeline())
        positions, triangles = (self._device.read(copy) for copy in self._copies)
        return [replace(self._mesh, positions=positions, triangles=triangles)]

    def vertex_map(self) -> NDArray[np.uint32]:
        """Each vertex is its own, (n,)."""
        return np.arange(self._given[0].shape[0], dtype=np.uint32)

    def check(self) -> Check:
        """How many numbers differ from those given."""
        (mesh,) = self.result()
        pairs = zip(self._given, (mesh.positions, mesh.triangles), strict=True)
        wrong = sum(int(np.count_nonzero(self._device.read(b) != values)) for b, values in pairs)
        return Check(wrong == 0, "numbers unlike the input's", wrong, 0)

    def counters(self) -> Mapping[str, int | float]:
        """Sizes in and out, and what the search found."""
        vertices, triangles = (copy.shape[0] for copy in self._copies)
        return {"vertices": vertices, "triangles": triangles, **self._more}

    def footprint(self) -> Footprint:
        """Input and output."""
        size = sum(buffer.size_bytes for buffer in self._given)
        vertices = self._given[0].shape[0]
        return Footprint(
            input_bytes=size,
            output_bytes=size,
            stored_vertices=vertices,
            stored_bytes=size,
            static_vertices=vertices,
            static_bytes=size,
        )

    def traffic(self) -> Mapping[str, Traffic]:
        """Everything read and written once."""
        return {STAGE: Traffic(2 * sum(buffer.size_bytes for buffer in self._given))}
