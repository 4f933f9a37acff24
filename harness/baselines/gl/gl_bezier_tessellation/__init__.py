"""Bezier patches by an OpenGL driver's tessellation stages, equal spacing: what they were made for.

A patch is sixteen vertices, its control points. The fixed-function tessellator cuts the unit square as the parametric
map is cut.

Source: Concheiro 2013, section 1.2; OpenGL 4.0 specification, section 2.12.
"""

from __future__ import annotations

from functools import partial
from typing import Any

from lodbench.harness.baselines.gl.bezier import KEPT, DrawnPatches, Params, gl_bezier_system
from lodbench.harness.baselines.gl.driver import assign, build, keep_patches
from lodbench.harness.baselines.gl.patches import MOST_VERTICES, check_segments
from lodbench.kernels.bezier.tessellated import control_rows

__all__ = ["BezierTessellation", "Params", "SYSTEM"]


class BezierTessellation(DrawnPatches):
    """Control points in a buffer, in draw calls of at most `MOST_VERTICES`.

    Raises:
        Unsupported: no OpenGL driver, none with tessellation, or a level past its limit.
    """

    def programs(self) -> tuple[Any, Any]:
        """See `Drawn`."""
        check_segments(self.gl, self.segments)
        stages = ("bezier_controls.vert", "bezier.tesc", "bezier.tese")
        programs = build(*stages, "surface.frag"), build(*stages, varyings=KEPT)
        for program in programs:
            assign(program, {"segments": float(self.segments)})
        return programs

    def upload(self) -> None:
        """See `Drawn`."""
        arrays = [(self.buffer(control_rows(self.patches.points)), "4f", "control_point")]
        self._array = self.gl.vertex_array(self.draw_program, arrays)
        self._points = self.gl.vertex_array(self.feedback_program, arrays)

    def draw(self, coarse: int) -> None:
        """See `Drawn`."""
        self._render(self._array, coarse)

    def _render(self, array: Any, coarse: int) -> None:
        """The first `coarse` patches, so many at a time."""
        self.gl.patch_vertices = 16
        each = max(MOST_VERTICES // (self.segments + 1) ** 2, 1)
        for first in range(0, coarse, each):
            count = min(each, coarse - first)
            array.render(self.gl.PATCHES, vertices=16 * count, first=16 * first)

    def keep(self, buffer: Any) -> None:
        """See `Drawn`."""
        draw = partial(self._render, self._points, self.coarse)
        keep_patches(self.feedback_program, buffer, draw)


SYSTEM = gl_bezier_system(
    "gl_bezier_tessellation",
    "Concheiro 2013, section 1.2, in OpenGL 4.0 tessellation",
    BezierTessellation,
)
