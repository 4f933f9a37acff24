"""Curved PN triangles under patterns."""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.opencl import Device
from lodbench.kernels.refine.pn_triangles.params import Params
from lodbench.kernels.refine.pn_triangles.surface import PnSurface
from lodbench.kernels.refine.refined import Refined


class PnTriangles(Refined):
    """A mesh as curved PN triangles: see `lodbench.kernels.refine.pn_triangles`."""

    def __init__(self, device: Device, mesh: TriangleMesh, params: Params) -> None:
        super().__init__(device, mesh, params, PnSurface(params))
