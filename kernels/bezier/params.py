"""The parameters that tessellations of Bezier patches have."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, TypeAlias

from lodbench.kernels.parameters import Parameters, Range

Level: TypeAlias = Annotated[int, Range(0, 10)]


@dataclass(frozen=True)
class BezierParams(Parameters):
    """How finely to tessellate.

    Attributes:
        level: of resolution, 0 to 10: a patch has 2^level segments along each side.
        normals: make normals beside points.
    """

    level: Level = 4
    normals: bool = True
