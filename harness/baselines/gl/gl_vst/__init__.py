"""Vertex shader tessellation in an OpenGL driver's vertex shader: the map drawn once per patch, instanced.

Source: Concheiro 2013, chapter 2 (VST), on real shaders; instances stand for the thesis's draw of several surfaces.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.gl.bezier import (
    KEPT,
    RECORD,
    DrawnPatches,
    Params,
    gl_bezier_system,
)
from lodbench.harness.baselines.gl.driver import build
from lodbench.kernels.bezier.lattice import lattice_parameters, lattice_triangles
from lodbench.kernels.bezier.reference import patch_scales

__all__ = ["Params", "SYSTEM", "Vst"]


class Vst(DrawnPatches):
    """The map per vertex; the control points as a matrix for each axis, and the scale, per instance."""

    def programs(self) -> tuple[Any, Any]:
        """See `Drawn`."""
        return build("bezier.vert", "surface.frag"), build("bezier.vert", varyings=KEPT)

    def upload(self) -> None:
        """See `Drawn`."""
        points, level = self.patches.points, self.params.level
        places = np.stack(lattice_parameters(level), axis=1).astype(np.float32)
        self._places = len(places)
        names = ("controls_x", "controls_y", "controls_z")
        arrays = [
            (self.buffer(places), "2f", "place"),
            (self.buffer(points.transpose(0, 3, 1, 2)), "16f 16f 16f/i", *names),
            (self.buffer(patch_scales(points)), "1f/i", "scale"),
        ]
        triangles = self.buffer(lattice_triangles(level))
        self._array = self.gl.vertex_array(self.draw_program, arrays, triangles)
        self._points = self.gl.vertex_array(self.feedback_program, arrays)

    def draw(self, coarse: int) -> None:
        """See `Drawn`."""
        self._array.render(instances=coarse)

    def keep(self, buffer: Any) -> None:
        """See `Drawn`."""
        self._points.transform(
            buffer, mode=self.gl.POINTS, vertices=self._places, instances=self.coarse
        )

    def feedback_bytes(self) -> int:
        """Of a row for each vertex."""
        return RECORD.itemsize * self.coarse * (self.segments + 1) ** 2

    def result(self) -> Sequence[TriangleMesh]:
        """Every patch's vertices in the map's order; patches share nothing."""
        kept = self.kept()
        first = np.arange(self.coarse)[:, None, None] * (self.segments + 1) ** 2
        triangles = (lattice_triangles(self.params.level)[None] + first).reshape(-1, 3)
        return [TriangleMesh(kept["point"].copy(), triangles, kept["normal"].copy())]


SYSTEM = gl_bezier_system("gl_vst", "Concheiro 2013, chapter 2 (VST), on an OpenGL driver", Vst)
