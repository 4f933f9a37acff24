"""Where the seconds of a frame or of a set-up went, by stage."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any


class _Host:
    """A block whose wall time counts towards a stage; a generator would take ten times as long to enter."""

    __slots__ = ("_seconds", "_stage", "_start")

    def __init__(self, seconds: dict[str, float], stage: str) -> None:
        self._seconds, self._stage = seconds, stage

    def __enter__(self) -> None:
        self._start = time.perf_counter()

    def __exit__(self, *raised: object) -> None:
        spent = time.perf_counter() - self._start
        self._seconds[self._stage] = self._seconds.get(self._stage, 0.0) + spent


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

    def host(self, stage: str) -> _Host:
        """Count the wall time of the block towards `stage`."""
        return _Host(self.stage_s, stage)

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
