"""The parameters of vertex shader tessellation."""

from __future__ import annotations

from dataclasses import dataclass

from lodbench.kernels.bezier.level_params import LeveledParams


@dataclass(frozen=True)
class Params(LeveledParams):
    """How finely to tessellate."""
