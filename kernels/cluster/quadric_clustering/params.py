"""The parameters of quadric vertex clustering."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from lodbench.kernels.cluster.warped import WarpedTarget
from lodbench.kernels.parameters import Range

Placement = Literal["robust", "paper", "average"]


@dataclass(frozen=True)
class Params(WarpedTarget):
    """How far and how to simplify; targets are those of `WarpedTarget`, and `cells` comes first.

    Attributes:
        placement: "robust", the minimum regularised towards the mean of the corners with 1e-3 of the trace, with 1e-2
            and 1e-1 where the step is longer than a cell, else the mean; "paper", the minimum where det(A) > 1e-11 in a
            unit box, else the mean; "average", the mean of the corners.
        strategy: "fused", passes 1 and 3 in one walk over the triangles; "separate", three passes timed apart. Both
            give the same triangles and bits.
        accumulate: "private", one float map per share of the triangles, added up at the end; "fixed_point", one map of
            64-bit integers and atomics, always in separate passes; "auto": private on a CPU. Each gives the same bits
            on every run; fixed_point also for any order of the triangles.
        chunks: private maps, 1 to 4; the number decides how sums are rounded, so it belongs to the parameters.
        remove_duplicates: of output triangles with the same three vertices, whichever way they face, keep the first;
            a target counts what is left.
    """

    placement: Placement = "robust"
    strategy: Literal["fused", "separate"] = "fused"
    accumulate: Literal["auto", "private", "fixed_point"] = "auto"
    chunks: Annotated[int, Range(1, 4)] = 2
    remove_duplicates: bool = False
