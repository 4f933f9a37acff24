"""Geometry shader tessellation in an OpenGL driver's geometry shader: a point per zone comes in, strips go out.

A driver allows 1024 values of output to each invocation, its own limit. Each of our 72 vertices has 13: clip position,
point, normal, parameters and the patch's number. The control points are a texture.

Source: Concheiro 2013, chapter 2 (GST), on real shaders.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from lodbench.harness.baselines.gl.bezier import KEPT, DrawnPatches, Params, gl_bezier_system
from lodbench.harness.baselines.gl.driver import assign, build, keep_patches
from lodbench.kernels.bezier.gst.zones import largest_zone
from lodbench.kernels.bezier.tessellated import control_rows
from lodbench.kernels.opencl import Unsupported

__all__ = ["Gst", "Params", "SYSTEM"]

VALUES, MOST_VALUES = 13, 1024  # of a vertex, and of an invocation


class Gst(DrawnPatches):
    """Zones by number alone; no vertex has data.

    Raises:
        Unsupported: no OpenGL driver, or more patches than a texture of it has rows.
    """

    def programs(self) -> tuple[Any, Any]:
        """See `Drawn`."""
        zone = self._zone = largest_zone(self.params.level, VALUES, MOST_VALUES)
        self._zones = self.segments**2 // (zone.rows * zone.columns)
        stages = ("bezier_zone.vert", "bezier_zone.geom")
        programs = build(*stages, "surface.frag"), build(*stages, varyings=KEPT)
        for program in programs:
            uniforms = {"segments": self.segments, "zone": (zone.rows, zone.columns)}
            assign(program, {**uniforms, "controls": 0})
        return programs

    def upload(self) -> None:
        """See `Drawn`."""
        most = int(self.gl.info["GL_MAX_TEXTURE_SIZE"])
        if self.coarse > most:
            raise Unsupported(f"needs a texture of {self.coarse:,} rows, driver has {most:,}")
        rows = control_rows(self.patches.points)
        self._controls = self.gl.texture((16, self.coarse), 4, rows.tobytes(), dtype="f4")
        self._controls.filter = self.gl.NEAREST, self.gl.NEAREST
        self.bytes += rows.nbytes
        self._array = self.gl.vertex_array(self.draw_program, [])
        self._points = self.gl.vertex_array(self.feedback_program, [])

    def draw(self, coarse: int) -> None:
        """See `Drawn`."""
        self._render(self._array, coarse)

    def _render(self, array: Any, coarse: int) -> None:
        self._controls.use(0)
        array.render(self.gl.POINTS, vertices=coarse * self._zones)

    def keep(self, buffer: Any) -> None:
        """See `Drawn`."""
        draw = partial(self._render, self._points, self.coarse)
        keep_patches(self.feedback_program, buffer, draw)

    def counters(self) -> Mapping[str, int | float]:
        """See `DrawnPatches`; and the zones."""
        zones = self.coarse * self._zones
        return {
            **super().counters(),
            "zones": zones,
            "zone_values": self._zone.vertices * VALUES,
        }


SYSTEM = gl_bezier_system("gl_gst", "Concheiro 2013, chapter 2 (GST), on an OpenGL driver", Gst)
