"""The parameters of clustering on an octree."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from lodbench.kernels.cluster.quadric_clustering.params import Border
from lodbench.kernels.cluster.target import ClusterTarget
from lodbench.kernels.parameters import Range

Rule = Literal["total", "rms", "maximum"]
MAX_LEVELS = 9
DEFAULT_LEVELS = 7
DEFAULT_ERROR = 1e-3


@dataclass(frozen=True)
class Params(ClusterTarget):
    """How far to simplify; targets are those of `Target`, at most one of them and `max_error`, which is else 1e-3.

    Attributes:
        max_error: largest error, share of the bounding-box diagonal, as `rule` has it.
        levels: of the finest grid, 2^levels cells along the longest box edge; None: by the target, twice as fine as a
            uniform grid would be, 7 without one.
        rule: what keeps to max_error: "maximum", the distance from a representative to the farthest plane of its
            triangles; "rms", the root of its quadric error over its area; "total", the root of what one vertex fewer
            adds to the quadric error over the area of the whole mesh. None: "total" for a target, "maximum" for
            max_error.
        shape: of cells: "boxes", cubes and what their halves, quarters and eighths are joined to along one or two axes;
            "cubes" as published, and always so with the rule "maximum".
        chunks: maps that are summed apart, 1 to 4; the number decides how sums are rounded, so it belongs here.
        border: "quadrics", border edges hold the representatives of their ends' cells, by planes upright on their
            triangles; "none", as published; "keep", border vertices stay where they are, each by itself, and come last.
    """

    max_error: Annotated[float, Range(0)] | None = None
    levels: Annotated[int, Range(1, MAX_LEVELS)] | None = None
    rule: Rule | None = None
    shape: Literal["boxes", "cubes"] = "boxes"
    chunks: Annotated[int, Range(1, 4)] = 2
    border: Border = "quadrics"

    @property
    def targeted(self) -> bool:
        """A number of triangles is asked for, not an error."""
        return self.target_count is not None or self.target_reduction is not None

    @property
    def measured(self) -> Rule:
        """The rule, as given or by what is asked for."""
        return self.rule or ("total" if self.targeted else "maximum")

    @property
    def boxed(self) -> bool:
        """Are children joined to boxes?"""
        return self.shape == "boxes" and self.measured != "maximum"

    @property
    def keeps_border(self) -> bool:
        """See `ClusterTarget`."""
        return self.border == "keep"

    @property
    def holds_border(self) -> bool:
        """Do border edges add quadrics?"""
        return self.border == "quadrics"

    @property
    def uses_border(self) -> bool:
        """See `ClusterTarget`."""
        return self.border != "none"

    @property
    def error(self) -> float:
        """The largest error where no number of triangles is asked for, share of the diagonal."""
        return DEFAULT_ERROR if self.max_error is None else self.max_error

    @property
    def grid_cells(self) -> int:
        """Of the finest grid along the longest box edge, where no number of triangles decides."""
        return 1 << (self.levels or DEFAULT_LEVELS)
