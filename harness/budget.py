"""Seconds that a run, or a group of it, may take."""

from __future__ import annotations

import time
from dataclasses import dataclass, field


@dataclass
class Budget:
    """Seconds that may be spent from now on; `cut` once something was left undone for want of them."""

    seconds: float
    cut: bool = False
    start: float = field(default_factory=lambda: time.perf_counter())

    @property
    def left(self) -> float:
        """Seconds; below 0 when more were spent."""
        return self.seconds - (time.perf_counter() - self.start)

    def stops(self) -> bool:
        """Is it spent? Asked where there is more to do, so that a yes is remembered as `cut`."""
        self.cut |= self.left <= 0
        return self.left <= 0
