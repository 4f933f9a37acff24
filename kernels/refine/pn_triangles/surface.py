"""Curved PN triangles as a part of refinement: cubic triangles made of corners and normals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.opencl import Buffer
from lodbench.kernels.refine.cubic import CubicSurface
from lodbench.kernels.refine.params import NormalOptions
from lodbench.kernels.refine.pn_triangles.reference import curved, curved_with_linear_normals
from lodbench.kernels.refine.reference import Reference
from lodbench.kernels.refine.surface import Coarse

if TYPE_CHECKING:
    from lodbench.kernels.subject import DeviceSubject


class PnSurface(CubicSurface):
    """See `lodbench.kernels.refine.pn_triangles`."""

    def __init__(self, options: NormalOptions) -> None:
        self._linear = options.shading_normals == "linear"

    def upload(self, subject: DeviceSubject, coarse: Coarse, corners: Buffer) -> Buffer:
        """The coefficients of each triangle."""
        defines = {"LINEAR": int(self._linear)}
        return self.coefficients(subject, coarse, "pn_triangles", corners, defines)

    def expected(self, coarse: Coarse, rows: NDArray[np.int64]) -> Reference:
        """See `Surface`."""
        return curved_with_linear_normals if self._linear else curved
