"""Where the results of a group are judged apart from the rest: around a place, or from an eye."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.stages.camera import look_at
from lodbench.kernels.system import View


@dataclass(frozen=True)
class Focus:
    """A ball about a place, or an eye there that looks at the middle of the box.

    Attributes:
        at: shares of the box along x, y, z; outside of 0 to 1 it is outside of the box.
        radius: of the ball, fraction of the diagonal; 0: an eye.
    """

    at: tuple[float, float, float]
    radius: float = 0.0

    def place(self, mesh: TriangleMesh) -> tuple[float, float, float]:
        """The middle of the ball, or the eye, model units."""
        low, high = (corner.astype(np.float64) for corner in mesh.box)
        x, y, z = (low + (high - low) * self.at).tolist()
        return x, y, z

    def region(self, mesh: TriangleMesh, weight: float) -> tuple[float, float, float, float, float]:
        """The ball as a warp's region, whose standard deviation is the radius."""
        return *self.place(mesh), self.radius * mesh.diagonal, weight

    def view(self, mesh: TriangleMesh) -> View:
        """What the eye sees, at the size of the tables' images."""
        low, high = (corner.astype(np.float64) for corner in mesh.box)
        return look_at(self.place(mesh), (low + high) / 2)
