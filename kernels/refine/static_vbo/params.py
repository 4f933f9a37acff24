"""The parameters of a refined mesh that is stored."""

from __future__ import annotations

from dataclasses import dataclass

from lodbench.kernels.refine.params import RefineParams, SurfaceOptions


@dataclass(frozen=True)
class Params(SurfaceOptions, RefineParams):
    """What is stored: how finely, which surface, and what raises it; the displacement stands still."""
