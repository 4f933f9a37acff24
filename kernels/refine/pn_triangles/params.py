"""The parameters of curved PN triangles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from lodbench.kernels.refine.params import RefineParams


@dataclass(frozen=True)
class Params(RefineParams):
    """How to refine, and which normals to shade by.

    Attributes:
        shading_normals: "quadratic", which can show an inflection, or "linear", interpolated along the triangle.
    """

    shading_normals: Literal["quadratic", "linear"] = "quadratic"
