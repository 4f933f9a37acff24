"""The parameters of dynamic and adaptive tessellation."""

from __future__ import annotations

from dataclasses import dataclass

from lodbench.kernels.bezier.adaptive_params import AdaptiveParams


@dataclass(frozen=True)
class Params(AdaptiveParams):
    """What asks for a vertex, on edges and inside."""
