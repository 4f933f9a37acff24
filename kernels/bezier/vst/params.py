"""The parameters of vertex shader tessellation."""

from __future__ import annotations

from dataclasses import dataclass

from lodbench.kernels.bezier.params import BezierParams


@dataclass(frozen=True)
class Params(BezierParams):
    """How finely to tessellate."""
