"""The parameters that tessellations of NURBS surfaces have."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

from lodbench.kernels.parameters import Parameters, Range

Level: TypeAlias = Annotated[int, Range(0, 10)]

BASES = ("stair", "triangle", "cox_de_boor")


@dataclass(frozen=True)
class NurbsParams(Parameters):
    """How finely to tessellate.

    Attributes:
        level: of resolution, 0 to 10: 2^level segments along each side of a surface, or of each of its KSQuads.
        per: what has so many segments: the surface, or the span between two knots and so the KSQuad.
        basis: how basis functions are evaluated: as sums of products, by the triangular table, or by the recursion's
            cells for each function by itself; points agree to a few roundings.
        normals: make normals beside points.
    """

    level: Level = 4
    per: Literal["surface", "span"] = "surface"
    basis: Literal["stair", "triangle", "cox_de_boor"] = "stair"
    normals: bool = True
