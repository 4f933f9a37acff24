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


def _checked(argument: str, **tags: Floats) -> None:
    for name, values in tags.items():
        low, high = RANGES[name]
        if values.size and not (low <= values.min() and values.max() <= high):
            got = f"{values.min():g} to {values.max():g}"
            raise ValueError(f"{argument}: expected {name} of {low:g} to {high:g}, got {got}")


def triangle_tags(mesh: TriangleMesh, options: TagOptions) -> Floats:
    """Of each triangle the tension of its corners, the sharpness and the bias of its edges, (m, 9) float32.

    The mesh's own tags, or those of the options. An edge has the product of its ends' sharpness and the mean of their
    bias, unless the mesh has tags of edges.

    Raises:
        ValueError: a tag out of its range.
    """
    given = (options.tension, options.sharpness, options.bias)
    tags = np.tile(np.asarray(given, np.float32), (mesh.vertex_count, 1))
    if mesh.tags is not None:
        tags = np.asarray(mesh.tags, np.float32)
        _checked("tags", **dict(zip(RANGES, tags.T, strict=True)))
    tension, sharpness, bias = (tags[mesh.triangles, k] for k in range(3))
    sharpness = sharpness * np.roll(sharpness, -1, axis=1)
    bias = np.float32(0.5) * (bias + np.roll(bias, -1, axis=1))
    if mesh.edge_tags is not None:
        sharpness, bias = np.moveaxis(np.asarray(mesh.edge_tags, np.float32), 2, 0)
        _checked("edge_tags", sharpness=sharpness, bias=bias)
    return np.concatenate([tension, sharpness, bias], axis=1)


class StSurface(CubicSurface):
    """See `lodbench.kernels.refine.st_triangles`.

    Raises:
        ValueError: tags out of range.
    """

    def __init__(self, options: TagOptions) -> None:
        self._options = options

    def upload(self, subject: DeviceSubject, coarse: Coarse, corners: Buffer) -> Buffer:
        """The coefficients of each triangle."""
        self._tags = triangle_tags(coarse.mesh, self._options)
        tags = subject.upload("tags", self._tags, np.float32, (None, 9))
        return self.coefficients(subject, coarse, "st_triangles", corners, tags=tags)

    def expected(self, coarse: Coarse, rows: NDArray[np.int64]) -> Reference:
        """The tagged surface of these coarse triangles."""
        return partial(
            tagged,
            tags=self._tags[rows].astype(np.float64).reshape(-1, 3, 3),
            from_p2=coarse.corners[rows, 18] > 0,
        )
