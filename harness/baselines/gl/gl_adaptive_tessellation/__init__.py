"""Curved PN triangles by an OpenGL driver's tessellation stages, each edge with the segments that the screen asks for.

A corner's depth is that of adaptive patterns by length on the screen; an edge's is the mean of its ends', rounded up,
the same from both sides. Inside, a triangle has as many rings as its finest edge.

Source: OpenGL 4.0 specification, section 2.12; Boubekeur & Schlick 2007, GPU Gems 3, chapter 5, for the tags.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from numpy.typing import NDArray

from lodbench.harness.baselines.gl.gl_pn_tessellation import PnTessellation
from lodbench.harness.baselines.gl.refined import Params as RefinedParams
from lodbench.harness.baselines.gl.refined import gl_system
from lodbench.kernels.parameters import Range
from lodbench.kernels.refine.adaptive_patterns.tags import pixels_per_unit, spans
from lodbench.kernels.system import View

__all__ = ["AdaptiveTessellation", "Params", "SYSTEM"]


@dataclass(frozen=True)
class Params(RefinedParams):
    """As the other subjects of the driver have them, and `pixels`: length of a segment that the screen allows."""

    pixels: Annotated[float, Range(0, open="low")] = 8.0


class AdaptiveTessellation(PnTessellation):
    """Cubic triangles, cut by the eye's distance."""

    params: Params

    def more_arrays(self) -> list[tuple[Any, str, str]]:
        """The mean length of the edges around each vertex."""
        lengths = spans(self.mesh, 1.0)[:, 0]
        return [(self.buffer(lengths), "1f", "span")]

    def uniforms(self, view: View) -> dict[str, Any]:
        """See `Refined`."""
        eye = tuple(float(x) for x in view.eye)
        per_segment = pixels_per_unit(view) / self.params.pixels
        return {**super().uniforms(view), "eye": eye, "per_segment": per_segment}

    def kept(self) -> NDArray[Any]:
        """See `Patches`: the buffer is as large as the finest would fill."""
        kept = super().kept()
        corners = kept["corners"]
        written = (corners[:, 0] != corners[:, 1]) | (corners[:, 1] != corners[:, 2])
        return kept[written]

    def least_rows(self) -> int:
        """See `Patches`: one triangle."""
        return 3

    def counters(self) -> Mapping[str, int | float]:
        """What the view of the whole mesh has; vertices are corners of triangles that share none."""
        rows = len(self.kept()) if self.coarse else 0
        return {**super().counters(), "vertices": rows, "triangles": rows // 3}


SYSTEM = gl_system(
    "gl_adaptive_tessellation",
    "OpenGL 4.0 tessellation by edge; GPU Gems 3, chapter 5, for the tags",
    AdaptiveTessellation,
    {"image_16": Params(16), "points_16": Params(16, "points")},
)
