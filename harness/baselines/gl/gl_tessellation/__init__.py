"""Refinement by an OpenGL driver's tessellation stages: control and evaluation shaders, equal spacing.

The fixed-function tessellator cuts a triangle into concentric rings, 1.5 segments^2 triangles, not into rows; edges
have as many segments. Levels end at the driver's limit, 64 as a rule.

Source: OpenGL 4.0 specification, section 2.12; the modern answer to Boubekeur & Schlick 2005.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.gl.driver import assign, build, context, keep_patches
from lodbench.harness.baselines.gl.refined import Params, Refined
from lodbench.kernels.opencl import Device, Unsupported
from lodbench.kernels.refine.surface import TOLERANCE
from lodbench.kernels.system import Check, System

__all__ = ["Params", "SYSTEM", "Tessellation"]

KEPT = ("surface_position", "shaded_normal", "weights", "corners")
RECORD = np.dtype([("point", "3f4"), ("normal", "3f4"), ("weights", "3f4"), ("corners", "3i4")])


def ring_triangles(segments: int) -> int:
    """Triangles of one coarse triangle: rings of 6 (k - 1) for k = segments, segments - 2 ...; 1 ends an odd series."""
    return (3 * segments**2) // 2


class Tessellation(Refined):
    """Corners in buffers, three to a patch."""

    def programs(self) -> tuple[Any, Any]:
        stages = ("tessellation.vert", "tessellation.tesc", "tessellation.tese")
        programs = build(*stages, "surface.frag"), build(*stages, varyings=KEPT)
        for program in programs:
            assign(program, {"segments": float(self.params.segments)})
        return programs

    def upload(self) -> None:
        arrays = [
            (self.buffer(self.mesh.positions), "3f", "position"),
            (self.buffer(np.asarray(self.mesh.normals, np.float32)), "3f", "normal"),
        ]
        indices = self.buffer(self.mesh.triangles)
        self.gl.patch_vertices = 3
        self._array = self.gl.vertex_array(self.draw_program, arrays, indices)
        self._points = self.gl.vertex_array(self.feedback_program, arrays, indices)

    def draw(self, coarse: int) -> None:
        self._array.render(self.gl.PATCHES, vertices=3 * coarse)

    def keep(self, buffer: Any) -> None:
        keep_patches(self._points, self.feedback_program, buffer)

    def feedback_bytes(self) -> int:
        return RECORD.itemsize * 3 * self.coarse * ring_triangles(self.params.segments)

    def result(self) -> Sequence[TriangleMesh]:
        """The triangles as the stages gave them, three points each."""
        kept = np.frombuffer(self.feedback(), RECORD)
        triangles = np.arange(len(kept), dtype=np.uint32).reshape(-1, 3)
        return [TriangleMesh(kept["point"].copy(), triangles, kept["normal"].copy())]

    def check(self) -> Check:
        """Points and normals at the weights that the tessellator chose, in float64; and how many there are."""
        kept = np.frombuffer(self.feedback(), RECORD)
        worst = 0.0
        if len(kept):
            rows = kept[:: max(len(kept) // 100_000, 1)]
            P, N = self.at(rows["corners"])
            weights = rows["weights"].astype(np.float64)[:, None]
            points, normals = (weights @ P)[:, 0], (weights @ N)[:, 0]
            length = np.linalg.norm(normals, axis=1)
            worst = float(np.abs(rows["point"] - points).max()) / max(float(np.abs(P).max()), 1e-37)
            turned = np.linalg.norm(rows["normal"] * length[:, None] - normals, axis=1)
            worst = max(worst, float(turned.max()), float(np.abs(weights.sum(-1) - 1).max()))
        what = "largest error of points (over the largest coordinate) and of unit normals at the tessellator's weights"
        return Check(worst <= TOLERANCE, what, worst, TOLERANCE)

    def counters(self) -> Mapping[str, int | float]:
        triangles = self.coarse * ring_triangles(self.params.segments)
        return {**super().counters(), "triangles": triangles}


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> Tessellation:
    """The corners in buffers of the driver.

    Raises:
        Unsupported: no OpenGL driver, none with tessellation, or more segments than it allows.
    """
    gl = context()
    if gl.version_code < 400:
        raise Unsupported(f"needs OpenGL 4.0 for tessellation, driver has {gl.version_code / 100}")
    most = int(gl.info["GL_MAX_TESS_GEN_LEVEL"]) if "GL_MAX_TESS_GEN_LEVEL" in gl.info else 64
    if params.segments > most:
        raise Unsupported(f"needs {params.segments} segments, driver has at most {most}")
    return Tessellation(mesh, params)


SYSTEM = System(
    name="gl_tessellation",
    family="baselines",
    source="OpenGL 4.0 tessellation, equal spacing",
    takes=(TriangleMesh,),
    prepare=prepare,
    cases={"image_8": Params(8), "points_8": Params(8, "points")},
    runs_on="gl",
)
