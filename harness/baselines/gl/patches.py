"""What the subjects share that leave refinement to an OpenGL driver's tessellator: buffers, feedback, the check.

The fixed-function tessellator cuts a triangle into concentric rings, 1.5 segments^2 triangles, not into rows; edges
have as many segments. Levels end at the driver's limit, 64 as a rule.

Source: OpenGL 4.0 specification, section 2.12.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.gl.driver import assign, build, keep_patches
from lodbench.harness.baselines.gl.refined import Refined
from lodbench.kernels.opencl import Unsupported
from lodbench.kernels.refine.surface import TOLERANCE
from lodbench.kernels.system import Check

KEPT = ("surface_position", "shaded_normal", "weights", "corners")
RECORD = np.dtype([("point", "3f4"), ("normal", "3f4"), ("weights", "3f4"), ("corners", "3i4")])
VERTEX = "tessellation.vert"
MOST_VERTICES = 1 << 15
"""Of one draw call. Past 65,536 llvmpipe numbers a draw's tessellated vertices from 0 again: triangles are missing and
others come twice, in 5 times the time at 16 segments and 18 times at 64. Smaller draws than these are no faster."""


def ring_triangles(segments: int) -> int:
    """Triangles of one coarse triangle: rings of 6 (k - 1) for k = segments, segments - 2 ...; 1 ends an odd series."""
    return (3 * segments**2) // 2


def ring_vertices(segments: int) -> int:
    """Vertices of one coarse triangle: 3 k on each ring, k = segments, segments - 2 ...; 1 ends an even series."""
    return 3 * sum(range(segments, 0, -2)) + (segments % 2 == 0)


def check_segments(gl: Any, segments: int) -> None:
    """Refuse what the driver's tessellator cannot cut.

    Raises:
        Unsupported: no tessellation, or more segments than it allows.
    """
    if gl.version_code < 400:
        raise Unsupported(f"needs OpenGL 4.0 for tessellation, driver has {gl.version_code / 100}")
    most = int(gl.info.get("GL_MAX_TESS_GEN_LEVEL", 64))
    if segments > most:
        raise Unsupported(f"needs {segments} segments, driver has at most {most}")


class Patches(Refined):
    """Corners in buffers, three to a patch, in draw calls of at most `MOST_VERTICES`.

    Attributes:
        control: the control shader's file.
        evaluation: the evaluation shader's file.

    Raises:
        Unsupported: no OpenGL driver, none with tessellation, or more segments than it allows.
    """

    control: str
    evaluation: str

    def programs(self) -> tuple[Any, Any]:
        segments = self.params.segments
        check_segments(self.gl, segments)
        stages = (VERTEX, self.control, self.evaluation)
        programs = build(*stages, "surface.frag"), build(*stages, varyings=KEPT)
        for program in programs:
            assign(program, {"segments": float(segments)})
        return programs

    def upload(self) -> None:
        arrays = [
            (self.buffer(self.mesh.positions), "3f", "position"),
            (self.buffer(np.asarray(self.mesh.normals, np.float32)), "3f", "normal"),
            *self.more_arrays(),
        ]
        indices = self.buffer(self.mesh.triangles)
        self._array = self.gl.vertex_array(self.draw_program, arrays, indices)
        self._points = self.gl.vertex_array(self.feedback_program, arrays, indices)

    def more_arrays(self) -> list[tuple[Any, str, str]]:
        """What else a vertex has, as moderngl takes it."""
        return []

    def draw(self, coarse: int) -> None:
        self._render(self._array, coarse)

    def _render(self, array: Any, coarse: int) -> None:
        """The first `coarse` triangles, so many at a time."""
        self.gl.patch_vertices = 3
        each = max(MOST_VERTICES // ring_vertices(self.params.segments), 1)
        for first in range(0, coarse, each):
            count = min(each, coarse - first)
            array.render(self.gl.PATCHES, vertices=3 * count, first=3 * first)

    def keep(self, buffer: Any) -> None:
        draw = partial(self._render, self._points, self.coarse)
        keep_patches(self.feedback_program, buffer, draw)

    def feedback_bytes(self) -> int:
        return RECORD.itemsize * 3 * self.coarse * ring_triangles(self.params.segments)

    def kept(self) -> NDArray[Any]:
        """What the stages give: three rows per triangle, of dtype `RECORD`."""
        return np.frombuffer(self.feedback(), RECORD)

    def result(self) -> Sequence[TriangleMesh]:
        """The triangles as the stages gave them, three points each."""
        kept = self.kept()
        triangles = np.arange(len(kept), dtype=np.uint32).reshape(-1, 3)
        return [TriangleMesh(kept["point"].copy(), triangles, kept["normal"].copy())]

    def check(self) -> Check:
        """Points and normals of some coarse triangles at the weights that the tessellator chose, in float64."""
        kept, chosen = self.kept(), self.chosen()
        kept = kept[np.isin(kept["corners"][:, 0], self.mesh.triangles[chosen, 0])]
        worst = 0.0
        for triangle in chosen:
            rows = kept[(kept["corners"] == self.mesh.triangles[triangle]).all(axis=1)]
            P, N = self.corners(np.array([triangle]))
            weights = rows["weights"].astype(np.float64)
            points, normals = (values[0] for values in self.reference(P, N, weights))
            length = np.linalg.norm(normals, axis=1, keepdims=True)
            size = max(float(np.abs(P).max()), 1e-37)
            errors = (
                np.abs(rows["point"] - points) / size,
                np.linalg.norm(rows["normal"] * length - normals, axis=1),
                np.abs(weights.sum(-1) - 1),
            )
            # a triangle of which parts are missing is infinitely wrong; NaN is the worst of all
            worst = float(np.max([worst, *(error.max(initial=0) for error in errors)]))
            worst = worst if len(rows) >= self.least_rows() else np.inf
        what = (
            "largest error of points (over the largest coordinate) and of unit normals at the tessellator's weights, "
            f"{len(chosen)} of {self.coarse} coarse triangles"
        )
        return Check(worst <= TOLERANCE, what, worst, TOLERANCE)

    def least_rows(self) -> int:
        """Of a coarse triangle of which no part is missing."""
        return 3 * ring_triangles(self.params.segments)

    def counters(self) -> Mapping[str, int | float]:
        triangles = self.coarse * ring_triangles(self.params.segments)
        return {**super().counters(), "triangles": triangles}
