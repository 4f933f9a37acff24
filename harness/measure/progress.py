"""How far long work has come: a bar with the time left on a terminal, plain lines elsewhere, or nothing."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Any


def duration(seconds: float) -> str:
    """Seconds as people say them: 4 s, 3 min 20 s, 2 h 05 min."""
    seconds = int(seconds + 0.5)
    if seconds < 60:
        return f"{seconds} s"
    minutes, seconds = divmod(seconds, 60)
    if minutes < 60:
        return f"{minutes} min {seconds:02d} s"
    return f"{minutes // 60} h {minutes % 60:02d} min"


class Progress:
    """Says what is being done, how far it is and what is left; all on standard error.

    Args:
        total: the work in any unit; `advance` counts towards it.
        quiet: say nothing.
    """

    def __init__(self, total: float, quiet: bool = False) -> None:
        self._total, self._done, self._kept = total, 0.0, 0.0
        self._quiet = quiet
        self._terminal = sys.stderr.isatty() and not quiet
        self._start = time.perf_counter()
        self._task = ""
        self._bar: Any = None

    def __enter__(self) -> Progress:
        if self._terminal:
            from rich import progress
            from rich.console import Console

            self._bar = progress.Progress(
                progress.TextColumn("{task.description}"),
                progress.BarColumn(),
                progress.TaskProgressColumn(),
                progress.TextColumn("{task.fields[left]}"),
                console=Console(stderr=True),
            )
            self._bar.start()
            self._id = self._bar.add_task("", total=self._total, left="")
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def left(self) -> str:
        """The time left, in words, or "" while nothing is known."""
        measured = self._done - self._kept
        if measured <= 0:
            return ""
        spent = time.perf_counter() - self._start
        return f"about {duration(spent * (self._total - self._done) / measured)} left"

    def task(self, what: str) -> None:
        """A new piece of the work begins; with the first one the clock does."""
        if not self._task:
            self._start = time.perf_counter()
        self._task = what
        if self._bar is not None:
            self._bar.update(self._id, description=what, left=self.left())
        elif not self._quiet:
            share = f"{self._done / self._total:4.0%}" if self._total else "    "
            print(f"{share}  {what}  {self.left()}".rstrip(), file=sys.stderr, flush=True)  # noqa: T201  a progress line is this file's job

    def step(self, what: str) -> None:
        """A step within the piece: shown on a terminal only."""
        if self._bar is not None:
            self._bar.update(self._id, description=f"{self._task}: {what}")

    def advance(self, amount: float, kept: bool = False) -> None:
        """This much is done; `kept` work was done by an earlier run and says nothing about speed."""
        self._done += amount
        self._kept += amount if kept else 0.0
        if self._bar is not None:
            self._bar.update(self._id, completed=self._done, left=self.left())
