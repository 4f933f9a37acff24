"""The parameters of fixed-function tessellation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from lodbench.kernels.bezier.params import BezierParams
from lodbench.kernels.parameters import Range


@dataclass(frozen=True)
class Params(BezierParams):
    """How finely to tessellate, and how the segments lie.

    Attributes:
        factor: segments along a side, 1 to 1024; None: 2^level. Hardware ends at 64.
        spacing: "integer", the factor rounded up; "odd" or "even", that many segments of which two are shorter.
        edges: factors of the edges: "uniform", all the same; or "length", by that of the edge's control polygon, the
            longest having `factor`.
    """

    factor: Annotated[float, Range(1, 1024)] | None = None
    spacing: Literal["integer", "odd", "even"] = "integer"
    edges: Literal["uniform", "length"] = "uniform"

    @property
    def largest(self) -> float:
        """The factor asked for."""
        return float(1 << self.level) if self.factor is None else self.factor
