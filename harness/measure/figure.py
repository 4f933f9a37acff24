"""A figure beside its limit, and what there is to see of a subject that it is measured of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from lodbench.kernels.opencl import Device
from lodbench.kernels.system import Check, Prepared


@dataclass(frozen=True)
class Figure:
    """What was measured; `limit` None where nothing is asked of it; `looked_at`: how much was looked at, for people."""

    value: float
    limit: float | None
    looked_at: str = ""

    @property
    def kept(self) -> bool:
        """Is it within its limit? NaN is not."""
        return self.limit is None or self.value <= self.limit


@dataclass(frozen=True)
class Seen:
    """A subject that ran, its input and params, its check, and the group's first subject if that ran."""

    device: Device
    prepared: Prepared
    surface: Any
    params: Any
    check: Check
    first: Prepared | None = None
