"""Curved PN triangles under patterns: coefficients made by one launch in set-up, evaluated in every frame."""

from __future__ import annotations

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.opencl import Buffer, Device, Program, Timeline
from lodbench.kernels.refine.pn_triangles.params import Params
from lodbench.kernels.refine.pn_triangles.reference import curved, curved_with_linear_normals
from lodbench.kernels.refine.refined import Refined

LARGEST = 1e37  # of a coordinate: its control points are finite
COEFFICIENTS = 76  # floats of a triangle, as in refine/cubic.cl


class PnTriangles(Refined):
    """A mesh as curved PN triangles: see `lodbench.kernels.refine.pn_triangles`.

    Raises:
        ValueError: a coordinate beyond 1e37.
        Unsupported: not even one refined triangle fits the device's memory.
    """

    files = ("refine/cubic_surface.cl",)
    flops = 82

    def __init__(self, device: Device, mesh: TriangleMesh, params: Params) -> None:
        size = float(np.abs(mesh.positions).max(initial=0))
        if size > LARGEST:
            raise ValueError(f"points: expected coordinates up to {LARGEST:g}, got {size:g}")
        self._linear = params.shading_normals == "linear"
        self.reference = curved_with_linear_normals if self._linear else curved
        super().__init__(device, mesh, params)

    def _unit_scale(self) -> float:
        """A power of two by which the model's size is near 1, as far as float32 has one."""
        return float(2.0 ** np.clip(-np.frexp(self._diagonal)[1], -126, 126))

    def surface(self, program: Program, corners: Buffer) -> Buffer:
        """The coefficients of each triangle, (m, 76)."""
        count = corners.shape[0]
        made = self.allocate("coefficients", (count, COEFFICIENTS), np.float32, "input")
        defines = {"LINEAR": int(self._linear)}
        with self.setup.host("coefficients"):
            self.device.build("refine/pn_triangles/setup.cl", defines=defines).launch(
                "pn_triangles_setup", count, stage="setup", corners=corners,
                coefficients=made, scale=self._unit_scale(), triangle_count=count,
            )(Timeline())  # fmt: skip
            self.device.wait()
        return made
