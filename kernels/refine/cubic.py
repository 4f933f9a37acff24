"""Cubic triangles: coefficients made by one launch in set-up, evaluated in every frame."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lodbench.kernels.opencl import Buffer, Timeline
from lodbench.kernels.refine.surface import Coarse, Surface

if TYPE_CHECKING:
    from lodbench.kernels.subject import DeviceSubject

COEFFICIENTS = 76  # floats of a triangle, as in cubic.cl


class CubicSurface(Surface):
    """What surfaces share whose triangles are cubic: they make the coefficients."""

    files = ("refine/cubic_surface.cl",)
    flops = 82
    largest = 1e37  # its control points are finite
    curved = True

    def coefficients(
        self,
        subject: DeviceSubject,
        coarse: Coarse,
        folder: str,
        corners: Buffer,
        defines: dict[str, int] | None = None,
        **arguments: Any,
    ) -> Buffer:
        """What the set-up kernel of a system's folder makes of each triangle, (m, 76)."""
        made = subject.allocate("coefficients", (coarse.count, COEFFICIENTS), np.float32, "input")
        scale = float(2.0 ** np.clip(-np.frexp(coarse.diagonal)[1], -126, 126))
        with subject.setup.host("coefficients"):
            subject.device.build(f"refine/{folder}/setup.cl", defines=defines).launch(
                f"{folder}_setup", coarse.count, stage="setup", corners=corners, coefficients=made,
                scale=scale, triangle_count=coarse.count, **arguments,
            )(Timeline())  # fmt: skip
            subject.device.wait()
        return made
