"""Where the seconds of a frame or of a set-up went, by stage."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any


@dataclass
class Timeline:
    """Seconds by stage, in the order in which the stages first ran.

    Device stages are events (end - start, summed by stage after `collect`); host stages are wall seconds
    measured with `host`. `wall_s` is the whole, from the first enqueue to the end of the one wait, less `untimed_s`:
    what a subject had to do before its work could begin and that is no part of it.
    """

    stage_s: dict[str, float] = field(default_factory=dict)
    wall_s: float = 0.0
    untimed_s: float = 0.0
    from_cache: dict[str, bool] = field(default_factory=dict)
    _events: list[tuple[str, Any]] = field(default_factory=list, repr=False)

    def add(self, stage: str, event: Any) -> None:
        """Note one device command; its time is read by `collect`, after the wait."""
        self._events.append((stage, event))

    @contextmanager
    def host(self, stage: str) -> Iterator[None]:
        """Count the wall time of the block towards `stage`."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.stage_s[stage] = self.stage_s.get(stage, 0.0) + time.perf_counter() - start

    @contextmanager
    def untimed(self) -> Iterator[None]:
        """Leave the wall time of the block out of the frame's."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.untimed_s += time.perf_counter() - start

    def collect(self) -> Timeline:
        """Read the finished events' times; call once the queue is empty."""
        for stage, event in self._events:
            seconds = (event.profile.end - event.profile.start) * 1e-9
            self.stage_s[stage] = self.stage_s.get(stage, 0.0) + seconds
        self._events.clear()
        return self

    @property
    def total_s(self) -> float:
        """The sum over stages, s."""
        return sum(self.stage_s.values())
