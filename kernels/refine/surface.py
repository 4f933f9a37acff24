"""What is evaluated over coarse triangles, as an exchangeable part: its kernels, what they read, and the reference."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Floats, TriangleMesh
from lodbench.kernels.opencl import Buffer, Text
from lodbench.kernels.refine.attributes import canonical, corner_attributes
from lodbench.kernels.refine.cracks import split_edges
from lodbench.kernels.refine.displacements import displacement_of
from lodbench.kernels.refine.params import RefineParams
from lodbench.kernels.refine.reference import Made, Reference, largest_error

if TYPE_CHECKING:
    from lodbench.kernels.subject import DeviceSubject

TOLERANCE = 2e-6  # a dozen float32 roundings, relative to the largest operand
CHECKED = 64  # coarse triangles that a check looks at


class Surface(ABC):
    """A surface over coarse triangles.

    Attributes:
        files: its kernels' file, and more where there are any; see `common/lattice_walk.cl`.
        flops: operations of one vertex, counted from the kernel.
        largest: coordinate that its sums can bear.
        curved: does it leave the flat triangles?
    """

    files: tuple[str, ...]
    flops: int
    largest = 1e38
    curved = False

    def upload(self, subject: DeviceSubject, coarse: Coarse, corners: Buffer) -> Buffer:
        """What its kernels read of each triangle, (m, floats): the corners themselves, or made of them."""
        return corners

    @abstractmethod
    def expected(self, coarse: Coarse, rows: NDArray[np.int64]) -> Reference:
        """The surface in float64 of these coarse triangles."""


class Coarse:
    """A coarse mesh on the device, the surface over it, and what displaces that.

    Attributes:
        mesh: with its own normals, or area-weighted ones, each triangle turned as `canonical` says.
        corners: (m, 19) float32, see `corner_attributes`.
        diagonal: of the box, model units, finite, as is its inverse.
        displacement: what raises the surface.
        values: (m, floats) on the device, what the surface's kernels read.
        table: uint32, on the device, what the displacement's kernels look up.
        attributes: float32, on the device, what they read of each triangle's corners.

    Raises:
        ValueError: a coordinate that the surface cannot bear, or a displacement that has no place on this mesh.
    """

    def __init__(
        self, subject: DeviceSubject, mesh: TriangleMesh, params: RefineParams, surface: Surface
    ) -> None:
        if (size := float(np.abs(mesh.positions).max(initial=0))) > surface.largest:
            got = f"expected coordinates up to {surface.largest:g}, got {size:g}"
            raise ValueError(f"points: {got}")
        self.mesh, self.surface = canonical(mesh), surface
        self.corners = corner_attributes(self.mesh)
        self.diagonal = min(max(mesh.diagonal, 2.0**-126), 3.4e38)
        self.displacement = displacement_of(params, self.mesh, self.diagonal)
        self._device = subject.device
        with subject.setup.host("upload"):
            corners = subject.upload("corners", self.corners, np.float32, (None, 19))
            self.table = subject.upload(
                "table", self.displacement.table(), np.uint32, role="pattern"
            )
            read = self.displacement.attributes()
            self._attribute_bytes = 0 if read is None else 4 * 3 * read.shape[2]
            read = np.zeros(1, np.float32) if read is None else read
            self.attributes = subject.upload("attributes", read, np.float32)
        self.values = surface.upload(subject, self, corners)

    @property
    def count(self) -> int:
        """Coarse triangles."""
        return self.mesh.triangle_count

    @property
    def triangle_bytes(self) -> int:
        """What the kernels read of each triangle."""
        return 4 * self.values.shape[1] + self._attribute_bytes

    @property
    def files(self) -> tuple[str | Text, ...]:
        """The kernels' files, in the order in which they are joined."""
        return (*self.displacement.files, *self.surface.files)

    @property
    def flops(self) -> int:
        """Operations of one vertex."""
        return self.surface.flops + self.displacement.flops

    @cached_property
    def cracked_edges(self) -> int:
        """Edges along which the refined surface may part: see `split_edges`; none where it stays flat."""
        leaves = self.surface.curved or self.displacement.is_any
        return split_edges(self.mesh) if leaves else 0

    def chosen(self) -> NDArray[np.int64]:
        """The coarse triangles that a check looks at, spread over the mesh."""
        last = max(self.count - 1, 0)
        return np.unique(np.linspace(0, last, min(CHECKED, self.count)).astype(np.int64))

    def error(
        self,
        rows: NDArray[np.int64],
        positions: Floats,
        normals: Floats,
        weights: NDArray[np.float64],
        time: float,
        then: Callable[[Made], Made] = lambda made: made,
    ) -> float:
        """How far points and normals of these triangles, (k, n, 3) each, are from float64: see `largest_error`.

        Args:
            rows: (k,) coarse triangles.
            positions: at `weights` of each.
            normals: likewise.
            weights: (n, 3) barycentric.
            time: of the displacement, s.
            then: what was done to them afterwards.
        """
        corners = self.corners[rows, :18].astype(np.float64).reshape(-1, 2, 3, 3)
        return largest_error(
            positions,
            normals,
            corners[:, 0],
            corners[:, 1],
            self.displacement.height(time, rows, self._device),
            self.surface.expected(self, rows),
            weights,
            then,
        )
