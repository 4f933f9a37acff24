"""Cubic triangles under patterns: coefficients made by one launch in set-up, evaluated in every frame."""

from __future__ import annotations

from typing import Any

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.opencl import Buffer, Device, Timeline
from lodbench.kernels.refine.params import RefineParams
from lodbench.kernels.refine.refined import Refined

COEFFICIENTS = 76  # floats of a triangle, as in cubic.cl
LARGEST = 1e37  # of a coordinate: its control points are finite


class CubicTriangles(Refined):
    """What systems share whose triangles are cubic: they make the coefficients.

    Raises:
        ValueError: a coordinate beyond 1e37.
        Unsupported: not even one refined triangle fits the device's memory.
    """

    files = ("refine/cubic_surface.cl",)
    flops = 82

    def __init__(self, device: Device, mesh: TriangleMesh, params: RefineParams) -> None:
        size = float(np.abs(mesh.positions).max(initial=0))
        if size > LARGEST:
            raise ValueError(f"points: expected coordinates up to {LARGEST:g}, got {size:g}")
        super().__init__(device, mesh, params)

    def coefficients(
        self, folder: str, corners: Buffer, defines: dict[str, int] | None = None, **arguments: Any
    ) -> Buffer:
        """What the set-up kernel of a system's folder makes of each triangle, (m, 76)."""
        count = corners.shape[0]
        made = self.allocate("coefficients", (count, COEFFICIENTS), np.float32, "input")
        scale = float(2.0 ** np.clip(-np.frexp(self._diagonal)[1], -126, 126))
        with self.setup.host("coefficients"):
            self.device.build(f"refine/{folder}/setup.cl", defines=defines).launch(
                f"{folder}_setup", count, stage="setup", corners=corners, coefficients=made,
                scale=scale, triangle_count=count, **arguments,
            )(Timeline())  # fmt: skip
            self.device.wait()
        return made
