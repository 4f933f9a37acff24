"""The parameters of scalar tagged triangles."""

from __future__ import annotations

from dataclasses import dataclass

from lodbench.kernels.refine.params import LevelParams, TagOptions


@dataclass(frozen=True)
class Params(TagOptions, LevelParams):
    """How to refine, and the tags of a mesh that brings none of its own."""
