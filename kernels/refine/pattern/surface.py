"""The flat surface as a part of refinement."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.refine.pattern.reference import flat
from lodbench.kernels.refine.reference import Reference
from lodbench.kernels.refine.surface import Coarse, Surface


class Flat(Surface):
    """Points and normals interpolated along each triangle."""

    files = ("refine/pattern/surface.cl",)
    flops = 34

    def expected(self, coarse: Coarse, rows: NDArray[np.int64]) -> Reference:
        """See `Surface`."""
        return flat
