"""The parameters of the rendering pipeline for NURBS surfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from lodbench.kernels.nurbs.params import NurbsParams

CULLING = ("none", "strong", "light", "certified")


@dataclass(frozen=True)
class Params(NurbsParams):
    """How finely to tessellate, and what is left out.

    Attributes:
        per: what has 2^level segments along each side: here always the span, and so the KSQuad.
        culling: which KSQuads are taken to face away: those whose control nets do in all parts (strong) or in their
            middle (light), or those that can be shown to (certified).
    """

    per: Literal["span"] = "span"
    culling: Literal["none", "strong", "light", "certified"] = "certified"
