"""The parameters of geometry shader tessellation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from lodbench.kernels.bezier.level_params import LeveledParams
from lodbench.kernels.parameters import Range


@dataclass(frozen=True)
class Params(LeveledParams):
    """How finely to tessellate, in which zones, and what their samples share.

    Attributes:
        reuse: what is evaluated once and used again: "row", the surface of a zone and the curve of each row; "zone",
            the surface; or "none", each sample begins with the control points.
        most_values: 32-bit values that one zone may emit, four for a point and four for a normal, as of a geometry
            shader.
    """

    reuse: Literal["row", "zone", "none"] = "row"
    most_values: Annotated[int, Range(32, 65536)] = 1024
