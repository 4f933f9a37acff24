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

    def stops(self, needed: float = 0.0) -> bool:
        """Is it spent, or too little for `needed` seconds? Asked where there is more to do: a yes is kept as `cut`."""
        over = self.left <= 0 or needed > self.left
        self.cut |= over
        return over
