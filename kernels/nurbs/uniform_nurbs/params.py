"""The parameters of uniform tessellation of NURBS surfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from lodbench.kernels.nurbs.params import NurbsParams
from lodbench.kernels.parameters import Range


@dataclass(frozen=True)
class Params(NurbsParams):
    """How finely to tessellate.

    Attributes:
        tolerance: in place of a level: the largest distance between triangles and their surface, as a share of the
            diagonal of the box of all surfaces; each span gets as few segments as keep it, and one at the least.
    """

    tolerance: Annotated[float, Range(1e-6, 1)] | None = None
