"""The parameters of semi-adaptive tessellation."""

from __future__ import annotations

from dataclasses import dataclass

from lodbench.kernels.bezier.adaptive_params import AdaptiveParams


@dataclass(frozen=True)
class Params(AdaptiveParams):
    """What asks for a vertex on an edge."""
