"""Scalar tagged triangles as a part of refinement: cubic triangles made of corners, normals and tags."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Floats, TriangleMesh
from lodbench.kernels.opencl import Buffer
from lodbench.kernels.refine.cubic import CubicSurface
from lodbench.kernels.refine.params import TagOptions
from lodbench.kernels.refine.reference import Reference
from lodbench.kernels.refine.st_triangles.reference import tagged
from lodbench.kernels.refine.surface import Coarse

if TYPE_CHECKING:
    from lodbench.kernels.subject import DeviceSubject

RANGES = {"tension": (-1.0, 1.0), "sharpness": (0.0, 1.0), "bias": (-1.0, 1.0)}


def vertex_tags(mesh: TriangleMesh, options: TagOptions) -> Floats:
    """Tension, sharpness and bias of each vertex, (n, 3) float32: the mesh's own, or those of the options.

    Raises:
        ValueError: a tag out of its range.
    """
    if mesh.tags is None:
        given = (options.tension, options.sharpness, options.bias)
        return np.tile(np.asarray(given, np.float32), (mesh.vertex_count, 1))
    tags = np.asarray(mesh.tags, np.float32)
    for (name, (low, high)), values in zip(RANGES.items(), tags.T, strict=True):
        if len(values) and not (low <= values.min() and values.max() <= high):
            got = f"{values.min():g} to {values.max():g}"
            raise ValueError(f"tags: expected {name} of {low:g} to {high:g}, got {got}")
    return tags


class StSurface(CubicSurface):
    """See `lodbench.kernels.refine.st_triangles`.

    Raises:
        ValueError: tags out of range.
    """

    def __init__(self, options: TagOptions) -> None:
        self._options = options

    def upload(self, subject: DeviceSubject, coarse: Coarse, corners: Buffer) -> Buffer:
        """The coefficients of each triangle."""
        self._tags = vertex_tags(coarse.mesh, self._options)[coarse.mesh.triangles]  # (m, 3, 3)
        tags = subject.upload("tags", self._tags, np.float32, (None, 3, 3))
        return self.coefficients(subject, coarse, "st_triangles", corners, tags=tags)

    def expected(self, coarse: Coarse, rows: NDArray[np.int64]) -> Reference:
        """The tagged surface of these coarse triangles."""
        return partial(
            tagged, tags=self._tags[rows].astype(np.float64), from_p2=coarse.corners[rows, 18] > 0
        )
