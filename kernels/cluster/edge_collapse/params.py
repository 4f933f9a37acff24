"""The parameters of edge collapse."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Literal

from lodbench.kernels.parameters import Range
from lodbench.kernels.targets import Target

DEFAULT_REDUCTION = 0.9


@dataclass(frozen=True)
class Params(Target):
    """How far to simplify; targets are those of `Target`, at most one of them; a tenth is left where none is given.

    Attributes:
        form: "blocks", each collapsed by a core, one edge after the other; "rounds" of collapses all over the mesh,
            as a GPU has them, of the same quality; "auto": blocks on CPUs, rounds elsewhere. Block, sweeps and gain are
            those of blocks alone.
        block: most triangles of a block; what fits a core's cache is fastest.
        sweeps: in which the target is to be met; as many more follow where it is not.
        gain: a sweep's share of triangles to go times this is the share of edges that it may collapse.
        normal_limit: degrees by which no triangle may turn in one collapse; 90 where the target is else missed.
        border_weight: of the planes upright on border edges and creases, times the square of their length; 0 is none.
        preserve_border: leave border vertices where they are.
        crease_angle: degrees between the normals of two triangles from which on their edge is held like a border; None
            holds none. The planes of the triangles hold creases by themselves, so this helps where they are faint.
    """

    form: Literal["auto", "blocks", "rounds"] = "auto"
    block: Annotated[int, Range(16, 4096)] = 1500
    sweeps: Annotated[int, Range(1, 64)] = 3
    gain: Annotated[float, Range(0, 2, open="low")] = 0.8
    normal_limit: Annotated[float, Range(0, 90, open="low")] = 80.0
    border_weight: Annotated[float, Range(0, 1e6)] = 1.0
    preserve_border: bool = False
    crease_angle: Annotated[float, Range(0, 180, open="high")] | None = None

    @property
    def crease_cosine(self) -> float:
        """Of the crease angle; -1 for none."""
        return -1.0 if self.crease_angle is None else math.cos(math.radians(self.crease_angle))

    def form_on(self, cpu: bool) -> str:
        """The form on a device that is a CPU, or none."""
        if self.form != "auto":
            return self.form
        return "blocks" if cpu else "rounds"

    def left(self, triangle_count: int) -> int:
        """Triangles that may be left of so many."""
        asked = self.triangles(triangle_count)
        if asked is None:
            asked = Target(target_reduction=DEFAULT_REDUCTION).triangles(triangle_count)
        assert asked is not None
        return asked
