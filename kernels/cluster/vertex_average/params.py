"""The parameters of vertex clustering with means."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from lodbench.kernels.cluster.warped import WarpedTarget
from lodbench.kernels.parameters import Range


@dataclass(frozen=True)
class Params(WarpedTarget):
    """How far to simplify; targets are those of `WarpedTarget`, and `cells` comes first.

    Attributes:
        chunks: maps that are summed apart, 1 to 64; the number decides how sums are rounded, so it belongs here.
    """

    chunks: Annotated[int, Range(1, 64)] = 2
