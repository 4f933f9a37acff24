"""Refinement by pattern in an OpenGL driver's vertex shader: the pattern drawn once per coarse triangle, instanced.

Source: Boubekeur & Schlick 2005, section 3.2, on real shaders; instances stand for the paper's draw calls.
"""

from __future__ import annotations

from typing import Any

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.gl.driver import build
from lodbench.harness.baselines.gl.refined import Params, Refined, corner_arrays, pattern_arrays
from lodbench.kernels.opencl import Device
from lodbench.kernels.system import System

__all__ = ["Pattern", "Params", "SYSTEM"]


class Pattern(Refined):
    """The pattern's weights per vertex, the coarse triangle's corners per instance."""

    def programs(self) -> tuple[Any, Any]:
        kept = ("surface_position", "shaded_normal")
        return build("pattern.vert", "surface.frag"), build("pattern.vert", varyings=kept)

    def upload(self) -> None:
        weights, triangles = pattern_arrays(self.params.segments)
        self._vertices = len(weights)
        arrays: list[tuple[Any, ...]] = [(self.buffer(weights), "2f", "weights")]
        arrays += [
            (self.buffer(values), "3f/i", name) for name, values in corner_arrays(self.mesh).items()
        ]
        self._array = self.gl.vertex_array(self.draw_program, arrays, self.buffer(triangles))
        self._points = self.gl.vertex_array(self.feedback_program, arrays)

    def draw(self, coarse: int) -> None:
        self._array.render(instances=coarse)

    def keep(self, buffer: Any) -> None:
        self._points.transform(
            buffer, mode=self.gl.POINTS, vertices=self._vertices, instances=self.coarse
        )


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> Pattern:
    """The pattern and the corners in buffers of the driver.

    Raises:
        Unsupported: no OpenGL driver.
    """
    return Pattern(mesh, params)


SYSTEM = System(
    name="gl_pattern",
    family="baselines",
    source="Boubekeur & Schlick 2005, section 3.2, on an OpenGL driver",
    takes=(TriangleMesh,),
    prepare=prepare,
    cases={"image_16": Params(16), "points_16": Params(16, "points")},
    runs_on="gl",
)
