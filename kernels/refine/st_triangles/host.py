"""Scalar tagged triangles: cubic triangles made of corners, normals and tags."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Floats, TriangleMesh
from lodbench.kernels.opencl import Buffer, Device
from lodbench.kernels.refine.cubic import CubicTriangles
from lodbench.kernels.refine.reference import Reference
from lodbench.kernels.refine.st_triangles.params import Params
from lodbench.kernels.refine.st_triangles.reference import tagged

RANGES = {"tension": (-1.0, 1.0), "sharpness": (0.0, 1.0), "bias": (-1.0, 1.0)}


def vertex_tags(mesh: TriangleMesh, params: Params) -> Floats:
    """Tension, sharpness and bias of each vertex, (n, 3) float32: the mesh's own, or those of the params.

    Raises:
        ValueError: a tag out of its range.
    """
    if mesh.tags is None:
        given = (params.tension, params.sharpness, params.bias)
        return np.tile(np.asarray(given, np.float32), (mesh.vertex_count, 1))
    tags = np.asarray(mesh.tags, np.float32)
    for (name, (low, high)), values in zip(RANGES.items(), tags.T, strict=True):
        if len(values) and not (low <= values.min() and values.max() <= high):
            got = f"{values.min():g} to {values.max():g}"
            raise ValueError(f"tags: expected {name} of {low:g} to {high:g}, got {got}")
    return tags


class StTriangles(CubicTriangles):
    """A mesh as scalar tagged triangles: see `lodbench.kernels.refine.st_triangles`.

    Raises:
        ValueError: tags out of range.
    """

    def __init__(self, device: Device, mesh: TriangleMesh, params: Params) -> None:
        self._vertex_tags = vertex_tags(mesh, params)
        super().__init__(device, mesh, params)

    def surface(self, corners: Buffer) -> Buffer:
        """The coefficients of each triangle."""
        self._tags = self._vertex_tags[self._mesh.triangles]  # (m, 3 corners, 3)
        tags = self.upload("tags", self._tags, np.float32, (None, 3, 3))
        return self.coefficients("st_triangles", corners, tags=tags)

    def expected(self, rows: NDArray[np.int64]) -> Reference:
        """The tagged surface of these coarse triangles."""
        return partial(
            tagged, tags=self._tags[rows].astype(np.float64), from_p2=self._corners[rows, 18] > 0
        )
