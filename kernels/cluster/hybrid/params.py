"""The parameters of the hybrid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from lodbench.kernels.cluster.edge_collapse.params import Params as EdgeParams
from lodbench.kernels.parameters import Range
from lodbench.kernels.targets import Target

First = Literal["grid", "octree"]
WORTH = 0.6  # share of the triangles from which on clustering first saves nothing


@dataclass(frozen=True)
class Params(Target):
    """How far to simplify; targets are those of `Target`, at most one of them; a tenth is left where none is given.

    Attributes:
        first: the clustering: "grid", one vertex per cell of an even grid; "octree", nearer where parts are flat, and
            as slow as edge collapse of all is.
        factor: triangles that the clustering is to leave, times the target; None: 2.7 for a tenth of the triangles,
            and 1.8 times that where a tenth of it is asked for.
        normal_limit: degrees by which no triangle may turn in one collapse.
        preserve_border: leave border vertices where they are.
        crease_angle: see edge_collapse.
        fit: in the end vertices move to where they fit the input best, as in edge_collapse.
    """

    first: First = "grid"
    factor: Annotated[float, Range(1)] | None = None
    normal_limit: Annotated[float, Range(0, 90, open="low")] = 80.0
    preserve_border: bool = False
    crease_angle: Annotated[float, Range(0, 180, open="high")] | None = None
    fit: bool = True

    def collapse(self, target: int) -> EdgeParams:
        """Of the second stage."""
        return EdgeParams(
            target_count=target, normal_limit=self.normal_limit,
            preserve_border=self.preserve_border, crease_angle=self.crease_angle, fit=self.fit,
        )  # fmt: skip

    def left(self, triangle_count: int) -> int:
        """Triangles that may be left of so many."""
        asked = EdgeParams(target_reduction=self.target_reduction, target_count=self.target_count)
        return asked.left(triangle_count)

    def coarse(self, triangle_count: int) -> int:
        """Triangles that the clustering is to leave of so many; all where it would save nothing."""
        target = max(self.left(triangle_count), 1)
        factor = self.factor or 2.7 * max(0.1 * triangle_count / target, 1.0) ** 0.25
        wanted = round(factor * target)
        return wanted if wanted < WORTH * triangle_count else triangle_count
