"""Interleaved sampling: frames in turns A B A B ..., how many of each, and what else the machine did meanwhile."""

from __future__ import annotations

import ctypes
import gc
import os
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import psutil

from lodbench.harness.measure.budget import Budget
from lodbench.harness.measure.precision import half_width
from lodbench.harness.record.environment import load_average
from lodbench.kernels.opencl import Timeline

WARMUPS = 3  # turns before the first counted sample, for subjects under SLOW_S
SAMPLES = 10  # the least number of counted samples of such a subject
MOST_SAMPLES = 40  # quick subjects take more, until this many or QUICK_S of their own time
QUICK_S = 0.6
NARROW = 0.05  # relative half-width of a ratio's interval at which sampling may end
MORE_S = (
    1.0  # that a group may take for that beyond its quotas, where no time budget says otherwise
)
MOST_TURNS = 200  # in which it does
SLOW_S, SLOW_SAMPLES = 2.0, 3
VERY_SLOW_S = 30.0  # one sample, and no warm-up of its own
WARM_S = 2e-3  # of frames before a warm sample: one alone still finds its second core asleep
CALM_S, MOST_CALM_S = 1e-3, 0.2  # others' threads are looked at for so long; and waited for


@dataclass(frozen=True)
class Sample:
    """One timed frame.

    `turn` counts the rounds of the interleaving, warm-ups included, so that equal turns are neighbours in time.
    `cpu_s` is the process's CPU time over all threads; `load` the machine's one-minute load average.
    """

    subject: str
    turn: int
    warmup: bool
    wall_s: float
    cpu_s: float
    load: float | None
    stage_s: Mapping[str, float] = field(default_factory=dict)


@contextmanager
def _no_collection() -> Iterator[None]:
    """Python's collector stands still: a collection within a frame would be counted as the subject's time."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def quota(wall_s: float, samples: int | None) -> tuple[int, int]:
    """(warm-ups, counted samples) of a subject whose first turn took `wall_s`.

    `samples` asks for an exact number; slow subjects still take fewer.
    """
    if wall_s > VERY_SLOW_S:
        return 0, 1
    if wall_s > SLOW_S:
        return 1, min(samples or SLOW_SAMPLES, SLOW_SAMPLES)
    if samples is not None:
        return WARMUPS, samples
    return WARMUPS, int(np.clip(QUICK_S / max(wall_s, 1e-9), SAMPLES, MOST_SAMPLES))


Frames = Callable[[], Timeline | None]


def take(subject: str, frame: Frames, turn: int, warmup: bool, warm: bool = False) -> Sample | None:
    """One frame of one subject, timed, with `warm` at once after others of its own; None when the frame gave up."""
    with _no_collection():
        if warm and not _warmed(frame):
            return None
        cpu = time.process_time()
        timeline = frame()
        cpu = time.process_time() - cpu
    if timeline is None:
        return None
    return Sample(
        subject, turn, warmup, timeline.wall_s, cpu, load_average(), dict(timeline.stage_s)
    )


def _warmed(frame: Frames) -> bool:
    """Once no thread of the process computes, frames for `WARM_S`, one at least; False when one gave up."""
    calm()
    start = time.perf_counter()
    while frame() is not None:
        if time.perf_counter() - start > WARM_S:
            return True
    return False


def calm() -> None:
    """Wait until no thread of this process computes: those of BLAS spin for 0.1 s after a product, on others' cores."""
    start = time.perf_counter()
    while time.perf_counter() - start < MOST_CALM_S:
        cpu = time.process_time()
        time.sleep(CALM_S)
        if time.process_time() - cpu < CALM_S / 2:
            return


def interleave(
    frames: Mapping[str, Frames],
    first_s: Mapping[str, float],
    *,
    samples: int | None = None,
    budget: Budget | None = None,
    narrow: float = 0.0,
    warm: bool = False,
) -> Iterator[Sample]:
    """Samples of all subjects in turns A B A B ..., each as soon as it is taken.

    Once all have their number, those go on whose ratio to the first subject, turn by turn, is not known well enough.

    Args:
        frames: one call per subject that runs one frame and waits for it; one that returns None takes no more turns.
        first_s: wall seconds of each subject's first frame, run before; decides how many samples it takes. That
            frame counts as the first warm-up, and as the only sample of a subject over 30 s.
        samples: counted samples per subject; None takes at least 10, more of quick subjects.
        budget: no new turn that would not fit, by each subject's last frame, once every subject has a counted sample.
        narrow: the half-width, relative to it, of a ratio's 95 % interval that is good enough. Sampling goes on for it
            through 200 turns at most, as long as the budget lasts; without one, or with one that has no end, for half
            a second. 0, or an exact number of samples, takes no more.
        warm: before each sample its subject runs frames that are not timed: see `Group`.

    Turn 0 is the first frame, which the caller has run.
    """
    quotas = {name: quota(first_s[name], samples) for name in frames}
    quotas = {name: (warmups, n) for name, (warmups, n) in quotas.items() if warmups}
    offset = max((warmups for warmups, _ in quotas.values()), default=0)
    most = max((n for _, n in quotas.values()), default=0)
    last_s = dict(first_s)
    taken: dict[str, dict[int, float]] = {name: {} for name in frames}
    for turn in range(1, offset + most):
        counted = turn >= offset
        needed = sum(last_s[name] for name, (_, n) in quotas.items() if turn < offset + n)
        if turn > offset and budget is not None and budget.stops(needed):
            return
        for name, (warmups, n) in list(quotas.items()):
            if offset - warmups < turn < offset + n:  # all subjects start to count at one turn
                sample = take(name, frames[name], turn, warmup=not counted, warm=warm)
                if sample is None:
                    del quotas[name]
                else:
                    last_s[name] = sample.wall_s
                    if counted:
                        taken[name][turn] = sample.wall_s
                    yield sample
    if narrow > 0 and samples is None and quotas:
        left = {name: frames[name] for name in quotas}
        yield from _go_on(left, taken, offset + most, narrow, budget, warm)


def _go_on(
    frames: Mapping[str, Frames],
    taken: dict[str, dict[int, float]],
    turn: int,
    narrow: float,
    budget: Budget | None,
    warm: bool,
) -> Iterator[Sample]:
    """Turns, from `turn` on, of the first subject and of those whose ratio to it is not known well enough.

    Args:
        frames: the subjects that may take more; those whose next sample does not fit into what time is left do not.
        taken: subject -> turn -> wall seconds of the counted samples so far; grows.
        turn: the next.
        narrow: the half-width that is good enough.
        budget: of the group; it is not cut by what is left undone here.
        warm: as of `interleave`.
    """
    limit = budget if budget is not None and budget.seconds < float("inf") else Budget(MORE_S)
    first = next(iter(frames))
    for number in range(turn, turn + MOST_TURNS):
        wide = [
            name for name in frames
            if (name != first or len(frames) == 1) and _width(taken[first], taken[name]) > narrow
        ]  # fmt: skip
        wide.sort(key=lambda name: min(taken[name].values(), default=0.0))
        while wide and sum(_last(taken[name]) for name in {first, *wide}) > limit.left:
            wide.pop()  # the slowest
        if not wide:
            return
        for name in (name for name in frames if name in {first, *wide}):
            sample = take(name, frames[name], number, warmup=False, warm=warm)
            if sample is None:
                return
            taken[name][number] = sample.wall_s
            yield sample


def _last(walls: Mapping[int, float]) -> float:
    return [*walls.values()][-1] if walls else 0.0


def _width(first: Mapping[int, float], other: Mapping[int, float]) -> float:
    """Relative half-width of the interval of a subject's ratio to the first; of its own median where it is that."""
    if other is first:
        return half_width(list(first.values()))
    return half_width([s / max(first[turn], 1e-12) for turn, s in other.items() if turn in first])


class PeakMemory:
    """How far the process's memory has risen above what it held when this was made; Linux only."""

    def __init__(self) -> None:
        self._start: int | None = None
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if os.name == "posix" else None
        if trim is not None:
            trim(
                0
            )  # what an earlier subject freed is the system's again, not this one's for nothing
        try:
            Path("/proc/self/clear_refs").write_text("5")  # the peak is counted anew from here
            self._start = self._read("VmRSS")
        except (OSError, ValueError):
            pass

    @staticmethod
    def _read(key: str) -> int:
        for line in Path("/proc/self/status").read_text("utf-8").splitlines():
            if line.startswith(key + ":"):
                return int(line.split()[1]) << 10
        raise ValueError(f"/proc/self/status: expected {key}, got none")

    def growth_bytes(self) -> int | None:
        """Bytes, or None where the system does not tell."""
        if self._start is None:
            return None
        return max(self._read("VmHWM") - self._start, 0)


class OtherLoad:
    """The share of the machine's CPU time that other processes took since this was made."""

    def __init__(self) -> None:
        self._machine = psutil.cpu_times()
        self._own = time.process_time()

    def share(self) -> float:
        now = psutil.cpu_times()
        total = sum(now) - sum(self._machine)
        idle = sum(
            getattr(now, name, 0.0) - getattr(self._machine, name, 0.0)
            for name in ("idle", "iowait")
        )
        own = time.process_time() - self._own
        # guest time is counted within user time on Linux; it only makes the share more cautious
        return round(float(np.clip((total - idle - own) / total, 0, 1)), 3) if total > 0 else 0.0
