"""The parameters of uniform tessellation of NURBS surfaces."""

from __future__ import annotations

from dataclasses import dataclass

from lodbench.kernels.nurbs.params import NurbsParams


@dataclass(frozen=True)
class Params(NurbsParams):
    """How finely to tessellate."""
