"""The parameters of generic refinement."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from lodbench.kernels.refine.params import LevelParams


@dataclass(frozen=True)
class Params(LevelParams):
    """How to refine, and in how many launches.

    Attributes:
        draw: "batched", one launch for all coarse triangles; or "per_triangle", one launch for each with its attributes
            as arguments, as the paper's draw calls did.
    """

    draw: Literal["batched", "per_triangle"] = "batched"
