"""Scalar tagged triangles under patterns."""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.opencl import Device
from lodbench.kernels.refine.refined import Refined
from lodbench.kernels.refine.st_triangles.params import Params
from lodbench.kernels.refine.st_triangles.surface import StSurface


class StTriangles(Refined):
    """A mesh as scalar tagged triangles: see `lodbench.kernels.refine.st_triangles`.

    Raises:
        ValueError: tags out of range.
    """

    def __init__(self, device: Device, mesh: TriangleMesh, params: Params) -> None:
        super().__init__(device, mesh, params, StSurface(params))
