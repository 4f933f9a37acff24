"""The parameters of edge collapse."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from lodbench.kernels.parameters import Range
from lodbench.kernels.targets import Target

DEFAULT_REDUCTION = 0.9
FOLD = 120.0  # degrees, as in block.cl


@dataclass(frozen=True)
class Params(Target):
    """How far to simplify: to a target of `Target`, at most one of them, within `max_error`, or as far as that goes; a
    tenth is left where none is given.

    Attributes:
        max_error: share of the bounding-box diagonal that no point of either surface may be away from the other; it may
            stand beside a target, and what is met first counts.
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
            holds folds alone, from 120 on, from which thin parts would shrink: no plane of theirs is across. Creases
            are held by their own planes, so that a smaller angle helps where they are faint.
        fit: in the end vertices move to where they fit the input best (`fit.py`); it costs little.
        normal_weight: the share of the diagonal that a change of 1 counts as, where normals do not change evenly
            (`penalties.py`); 0 lets them count for nothing, 0.01 is a little, 0.1 much.
        uv_weight: the same of texture coordinates.
        colour_weight: the same of colours.
    """

    max_error: Annotated[float, Range(0)] | None = None
    form: Literal["auto", "blocks", "rounds"] = "auto"
    block: Annotated[int, Range(16, 4096)] = 1500
    sweeps: Annotated[int, Range(1, 64)] = 3
    gain: Annotated[float, Range(0, 2, open="low")] = 0.8
    normal_limit: Annotated[float, Range(0, 90, open="low")] = 80.0
    border_weight: Annotated[float, Range(0, 1e6)] = 1.0
    preserve_border: bool = False
    crease_angle: Annotated[float, Range(0, 180, open="high")] | None = None
    fit: bool = True
    normal_weight: Annotated[float, Range(0, 1e3)] = 0.0
    uv_weight: Annotated[float, Range(0, 1e3)] = 0.0
    colour_weight: Annotated[float, Range(0, 1e3)] = 0.0

    BESIDE: ClassVar[tuple[str, ...]] = ("max_error",)

    @property
    def crease_cosine(self) -> float:
        """Of the crease angle, or of folds."""
        return math.cos(math.radians(FOLD if self.crease_angle is None else self.crease_angle))

    @property
    def targeted(self) -> bool:
        """Is a number of triangles to be met? With an error alone there is none."""
        counted = self.target_count is not None or self.target_reduction is not None
        return counted or self.max_error is None

    def form_on(self, cpu: bool) -> str:
        """The form on a device that is a CPU, or none."""
        if self.form != "auto":
            return self.form
        return "blocks" if cpu else "rounds"

    def left(self, triangle_count: int) -> int:
        """Triangles that may be left of so many."""
        asked = self.triangles(triangle_count)
        if not self.targeted:
            return min(1, triangle_count)
        if asked is None:
            asked = Target(target_reduction=DEFAULT_REDUCTION).triangles(triangle_count)
        assert asked is not None
        return asked
