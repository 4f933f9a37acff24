"""The parameters of the rendering pipeline for NURBS surfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from lodbench.kernels.nurbs.params import NurbsParams
from lodbench.kernels.parameters import Range

CULLING = ("none", "strong", "light", "certified")
ADAPTIVE = ("adaptive", "non_uniform")


@dataclass(frozen=True)
class Params(NurbsParams):
    """What is left out, and how finely what stays is cut into KSDices.

    Attributes:
        level: of resolution, 0 to 10: 2^level segments along each side of a KSQuad; where they adapt, at the most.
        per: what has so many segments: here always the span, and so the KSQuad.
        culling: which KSQuads are taken to face away: those whose control nets do in all parts (strong) or in their
            middle (light), or those that can be shown to (certified); each leaves out what is beside the image, too.
        sampling: how many KSDices: "level", as many on every KSQuad; "adaptive", by the screen; "non_uniform", by the
            screen, with places even there; or "one" to a KSQuad. Without a view, by that of a camera that sees all.
        pixel_area: pixels that a KSDice may cover where they adapt.
        edges: "watertight", KSQuads that share a border have the same vertices there; or "tolerant", KSQuads on borders
            of surfaces have twice as many segments, and cracks are left to be smaller than a pixel.
        dice_culling: KSDices that face away are left out, too.
        inside_out: surfaces are turned first. What faces the eye is told by S_u x S_v, which must point outwards.
    """

    per: Literal["span"] = "span"
    culling: Literal["none", "strong", "light", "certified"] = "certified"
    sampling: Literal["level", "adaptive", "non_uniform", "one"] = "level"
    pixel_area: Annotated[float, Range(0.01, 1e6)] = 8.0
    edges: Literal["watertight", "tolerant"] = "watertight"
    dice_culling: bool = False
    inside_out: bool = False

    @property
    def adapts(self) -> bool:
        """By the screen?"""
        return self.sampling in ADAPTIVE

    @property
    def finest(self) -> int:
        """Segments along a side of a KSQuad, at the most where they adapt."""
        return 1 if self.sampling == "one" else 1 << self.level
