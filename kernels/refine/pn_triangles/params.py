"""The parameters of curved PN triangles."""

from __future__ import annotations

from dataclasses import dataclass

from lodbench.kernels.refine.params import LevelParams, NormalOptions


@dataclass(frozen=True)
class Params(NormalOptions, LevelParams):
    """How to refine, and which normals to shade by."""
