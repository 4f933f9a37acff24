"""The parameters that both adaptive tessellations have, and what a quality comes to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from lodbench.kernels.bezier.params import BezierParams, Level
from lodbench.kernels.parameters import Range

QUALITIES = {
    "distance": {"high": 3e-4, "medium": 1e-3, "low": 3e-3},
    "flat": {"high": 5e-3, "medium": 3e-2, "low": 1e-1},
    "length": {"high": 12.0, "medium": 24.0, "low": 48.0},
    "mean": {"high": 5e-9, "medium": 5e-8, "low": 5e-7},
}
"""The least measure that inserts a vertex, by test: a reconstruction, such that a model's mean error is near the same
with each test."""


@dataclass(frozen=True)
class AdaptiveParams(BezierParams):
    """What asks for a vertex, and how many there may be at the most.

    Attributes:
        level: of resolution at the finest, 0 to 10: at most 2^level segments along each side of a patch.
        test: of each vertex that may be inserted: "distance" from the middle of the chord; "flat", the angle between
            the normals at the chord's ends; or "length" of the chord on the screen. Or "mean", which is none of the
            thesis's: of each cell as a whole, so that the mean error is least for as many triangles, whatever the view.
        quality: "high", "medium" or "low": the threshold of the test.
        threshold: that threshold as a number, in place of `quality`: a share of the box's diagonal; one less the cosine
            of the angle; pixels, of which the diagonal has 1024 where there is no view; or the mean error that a
            triangle must save, a share of the diagonal. 0 inserts all.
        depth: the finest level of a coarse triangle, 0 to 3, at most `level`: a patch begins with
            2^(level - depth) cells along each side, two coarse triangles each.
        fitted: do vertices rise over the surface, by the test "mean" alone, so that triangles lie on both sides of it?
            Then the mean error is about half. Otherwise, and by the other tests, they lie on it.
    """

    level: Level = 5
    test: Literal["distance", "flat", "length", "mean"] = "distance"
    quality: Literal["high", "medium", "low"] = "high"
    threshold: Annotated[float, Range(0)] | None = None
    depth: Annotated[int, Range(0, 3)] = 3
    fitted: bool = True

    @property
    def rises(self) -> bool:
        """Do vertices leave the surface?"""
        return self.fitted and self.test == "mean"

    @property
    def evaluates_normals(self) -> bool:
        """Whether they are asked for or not: what rises does so along them."""
        return self.normals or self.rises

    @property
    def finest_depth(self) -> int:
        """Levels below the coarse triangles that there are."""
        return min(self.depth, self.level)

    @property
    def base(self) -> int:
        """The level of the coarse triangles."""
        return self.level - self.finest_depth

    @property
    def least(self) -> float:
        """The threshold."""
        return QUALITIES[self.test][self.quality] if self.threshold is None else self.threshold
