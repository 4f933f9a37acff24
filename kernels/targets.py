"""How far a simplifier is to go, in words that every system and every baseline shares."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, TypeVar

from lodbench.kernels.parameters import Parameters, Range

TARGETS = ("target_reduction", "target_count", "cells", "max_error")
"""Fields of a simplifier's Params of which at most one may be given; a system has those that it can keep to, and says
which may stand beside another."""

CLOSE = 0.95
"""At least this share of a target counts as met."""

T = TypeVar("T", bound="Target")


def given_targets(values: Mapping[str, Any]) -> dict[str, Any]:
    """The targets among `values` that are not None; `max_error` beside another is the method's to take or to refuse.

    Raises:
        ValueError: more than one of the others, or none at all.
    """
    given = {name: values[name] for name in TARGETS if values.get(name) is not None}
    if not given:
        names = ", ".join(name for name in TARGETS if name in values)
        raise ValueError(f"{names}: expected one of them, got none")
    given_target({name: value for name, value in given.items() if name != "max_error"})
    return given


def given_target(values: Mapping[str, Any]) -> str | None:
    """The one target among `values` that is not None, or None.

    Raises:
        ValueError: more than one.
    """
    given = [name for name in TARGETS if values.get(name) is not None]
    if len(given) > 1:
        names = ", ".join(name for name in TARGETS if name in values)
        raise ValueError(f"{names}: expected one of them, got {' and '.join(given)}")
    return given[0] if given else None


@dataclass(frozen=True, kw_only=True)
class Target(Parameters):
    """How many triangles are to be left; with neither, the system's own default counts.

    Attributes:
        target_reduction: share of the triangles removed, 0 to below 1; 0.9 leaves a tenth, rounded down, at least one.
        target_count: triangles left at most, at least 1.
    """

    target_reduction: Annotated[float, Range(0, 1, open="high")] | None = None
    target_count: Annotated[int, Range(1)] | None = None

    BESIDE: ClassVar[tuple[str, ...]] = ()
    """Of `TARGETS`, what may stand beside another one."""

    def __post_init__(self) -> None:
        super().__post_init__()
        given_target({name: value for name, value in vars(self).items() if name not in self.BESIDE})

    def counted(self: T, triangle_count: int) -> T:
        """The same with `target_count` in place of a reduction of so many triangles."""
        if self.target_reduction is None:
            return self
        left = max(1, math.floor(triangle_count * (1 - self.target_reduction) + 1e-6))
        return dataclasses.replace(self, target_reduction=None, target_count=left)

    def triangles(self, triangle_count: int) -> int | None:
        """Triangles asked for of so many, never more than there are; None where neither is given."""
        wanted = self.counted(triangle_count).target_count
        return None if wanted is None else min(wanted, triangle_count)


def missed(target: int, triangles: int) -> dict[str, int | float]:
    """The counters of a target: `target`, and `target_gap`, triangles short of it, negative where there are more."""
    return {"target": target, "target_gap": target - triangles}


def off_target(counters: Mapping[str, int | float]) -> str:
    """By how much a result misses its target, in words; "" where it keeps it, to 95 %, or had none."""
    target, gap = counters.get("target", 0), counters.get("target_gap", 0)
    if 0 <= gap <= (1 - CLOSE) * target:
        return ""
    return f"{abs(gap):,} {'fewer' if gap > 0 else 'more'} than the {target:,} asked for"
