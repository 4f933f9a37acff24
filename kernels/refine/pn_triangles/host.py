"""Curved PN triangles: cubic triangles made of corners and normals."""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.opencl import Buffer, Device
from lodbench.kernels.refine.cubic import CubicTriangles
from lodbench.kernels.refine.pn_triangles.params import Params
from lodbench.kernels.refine.pn_triangles.reference import curved, curved_with_linear_normals


class PnTriangles(CubicTriangles):
    """A mesh as curved PN triangles: see `lodbench.kernels.refine.pn_triangles`."""

    def __init__(self, device: Device, mesh: TriangleMesh, params: Params) -> None:
        self._linear = params.shading_normals == "linear"
        self.reference = curved_with_linear_normals if self._linear else curved
        super().__init__(device, mesh, params)

    def surface(self, corners: Buffer) -> Buffer:
        """The coefficients of each triangle."""
        return self.coefficients("pn_triangles", corners, {"LINEAR": int(self._linear)})
