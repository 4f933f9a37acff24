"""The parameters of clustering on an octree."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from lodbench.kernels.parameters import Range
from lodbench.kernels.targets import Target

Rule = Literal["total", "rms", "maximum"]
MAX_LEVELS = 9
DEFAULT_LEVELS = 7
DEFAULT_ERROR = 1e-3


@dataclass(frozen=True)
class Params(Target):
    """How far to simplify; targets are those of `Target`, at most one of them and `max_error`, which is else 1e-3.

    Attributes:
        max_error: largest error of a node, share of the bounding-box diagonal.
        levels: of the finest grid, 2^levels cells along the longest box edge; None: by the target, 7 without one.
        rule: what a node's error is: "maximum", the distance from its representative to the farthest plane of its
            triangles; "rms", the root of its quadric error over its area; "total", the root of that error over the
            area of the whole mesh, which is what the node adds to the mesh's error. None: "total" for a target,
            "maximum" for max_error.
        whole: a node is used where its descendants' errors keep to the threshold too, else where its own does.
        chunks: maps that are summed apart, 1 to 4; the number decides how sums are rounded, so it belongs here.
    """

    max_error: Annotated[float, Range(0)] | None = None
    levels: Annotated[int, Range(1, MAX_LEVELS)] | None = None
    rule: Rule | None = None
    whole: bool = True
    chunks: Annotated[int, Range(1, 4)] = 2

    @property
    def targeted(self) -> bool:
        """A number of triangles is asked for, not an error."""
        return self.target_count is not None or self.target_reduction is not None

    @property
    def measured(self) -> Rule:
        """The rule, as given or by what is asked for."""
        return self.rule or ("total" if self.targeted else "maximum")

    @property
    def error(self) -> float:
        """The largest error where no number of triangles is asked for, share of the diagonal."""
        return DEFAULT_ERROR if self.max_error is None else self.max_error

    @property
    def grid_cells(self) -> int:
        """Of the finest grid along the longest box edge."""
        return 1 << (self.levels or DEFAULT_LEVELS)
