"""The parameters of quadric vertex clustering."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from lodbench.kernels.cluster.warped import WarpedTarget
from lodbench.kernels.parameters import Range

Placement = Literal["robust", "paper", "average"]
Border = Literal["quadrics", "none", "keep"]
HEAVINESS = 1.0  # of a border edge's plane, by the square of its length


@dataclass(frozen=True)
class Params(WarpedTarget):
    """How far and how to simplify; targets are those of `WarpedTarget`, and `cells` comes first.

    Attributes:
        placement: "robust", the minimum regularised towards the mean of the corners with 1e-3 of the trace, with 1e-2
            and 1e-1 where the step is longer than a cell, else the mean; "paper", the minimum where det(A) > 1e-11 in a
            unit box, else the mean; "average", the mean of the corners.
        strategy: "fused", passes 1 and 3 in one walk over the triangles; "separate", three passes timed apart. Both
            give the same triangles and bits.
        accumulate: "private", one float map per share of the triangles, summed by one item each; "slabs", the same maps
            and bits, summed by one item for each run of cells out of lists of its triangles: more work, for any number
            of cores; "fixed_point", one map of 64-bit integers and atomics, always in separate passes. "auto":
            fixed_point on what is no CPU; else slabs where there are more than twice as many as maps, and private. Each
            gives the same bits on every run; fixed_point also for any order of the triangles.
        chunks: maps of private and slabs, 1 to 4; the number decides how sums are rounded, so it belongs to the
            parameters.
        slabs: runs of cells, and about as many shares of the triangles, at most 256; 0: one for each core, of 4,096
            triangles at the least. Their number changes no bit.
        border: "quadrics", border edges hold the representatives of their ends' cells, by planes upright on their
            triangles (with placement "robust"); "none", as published; "keep", border vertices stay where they are,
            each by itself, and come last.
    """

    placement: Placement = "robust"
    strategy: Literal["fused", "separate"] = "fused"
    accumulate: Literal["auto", "private", "slabs", "fixed_point"] = "auto"
    chunks: Annotated[int, Range(1, 4)] = 2
    slabs: Annotated[int, Range(0, 256)] = 0
    border: Border = "quadrics"

    @property
    def keeps_border(self) -> bool:
        """See `ClusterTarget`."""
        return self.border == "keep"

    @property
    def holds_border(self) -> bool:
        """Do border edges add quadrics?"""
        return self.border == "quadrics" and self.placement == "robust"

    @property
    def uses_border(self) -> bool:
        """See `ClusterTarget`."""
        return self.keeps_border or self.holds_border
