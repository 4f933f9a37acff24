"""The refined mesh stored in full and drawn by an OpenGL driver's vertex and fragment shaders.

Source: the "Static VBO" rows of Boubekeur & Schlick 2005, figure 7, on real shaders.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lodbench.harness.baselines.gl.driver import build
from lodbench.harness.baselines.gl.refined import Params, Refined, gl_system
from lodbench.kernels.refine.lattice import lattice_weights, refined_mesh

__all__ = ["Params", "SYSTEM", "StaticVbo"]


class StaticVbo(Refined):
    """Positions, normals and indices in buffers of the driver."""

    def programs(self) -> tuple[Any, Any]:
        kept = ("surface_position", "shaded_normal")
        return build("surface.vert", "surface.frag"), build("surface.vert", varyings=kept)

    def upload(self) -> None:
        mesh, segments = self.mesh, self.params.segments
        normals = np.asarray(mesh.normals, np.float32)
        if segments > 1:
            weights = lattice_weights(segments)
            points = (weights @ mesh.positions[mesh.triangles].astype(np.float64)).reshape(-1, 3)
            bent = (weights @ normals[mesh.triangles].astype(np.float64)).reshape(-1, 3)
            length = np.linalg.norm(bent, axis=1, keepdims=True)
            bent = np.where(length > 0, bent / np.where(length > 0, length, 1), (0.0, 0.0, 1.0))
            mesh = refined_mesh(mesh, segments, points.astype("f4"), bent.astype("f4"))
            normals = np.asarray(mesh.normals, np.float32)
        arrays = [
            (self.buffer(mesh.positions), "3f", "position"),
            (self.buffer(normals), "3f", "normal"),
        ]
        self._stored = mesh.vertex_count
        self._array = self.gl.vertex_array(self.draw_program, arrays, self.buffer(mesh.triangles))
        self._points = self.gl.vertex_array(self.feedback_program, arrays)

    def draw(self, coarse: int) -> None:
        self._array.render(vertices=3 * self.params.segments**2 * coarse)

    def keep(self, buffer: Any) -> None:
        self._points.transform(buffer, mode=self.gl.POINTS, vertices=self._stored)

    def feedback_bytes(self) -> int:
        return 24 * self._stored

    def points_and_normals(self) -> tuple[Any, Any]:
        if self.params.segments > 1 or not self.coarse:
            return super().points_and_normals()
        both = np.frombuffer(self.feedback(), np.float32).reshape(-1, 6)
        # pattern order of one segment: P0, P1, P2
        return both[self.mesh.triangles][..., :3], both[self.mesh.triangles][..., 3:]

    def counters(self) -> dict[str, int | float]:
        stored = self._stored if self.coarse else 0
        return {**super().counters(), "vertices": stored}


SYSTEM = gl_system(
    "gl_static_vbo",
    "Boubekeur & Schlick 2005, figure 7 (Static VBO), on an OpenGL driver",
    StaticVbo,
    {"image_1": Params(1), "image_16": Params(16), "points_16": Params(16, "points")},
)
