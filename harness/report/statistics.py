"""What samples say: summaries, ratios taken pair by pair, slopes, noise."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats

from lodbench.harness.measure.precision import CONFIDENCE, ENOUGH, median_interval
from lodbench.harness.measure.timing import SAMPLES

NOISY = 0.10
"""A row is noisy where its median may be off by more than this share: believing it costs what its reason says."""
NOISY_CPU = (
    0.75  # a starved sample has less than this share of the subject's usual CPU time per wall time
)
NOISY_OTHERS = 0.15  # share of the machine's CPU time taken by other processes during the group
MOST_OTHERS = (
    0.40  # from here on the least sample may be as disturbed as the rest, and says nothing
)

RESAMPLES = 2000  # of a bootstrap


@dataclass(frozen=True)
class Summary:
    """Median, minimum, quartiles and number of some seconds; `few` when there are too few to say much."""

    n: int
    median: float
    minimum: float
    lower: float
    upper: float

    @property
    def few(self) -> bool:
        return self.n < SAMPLES


def summary(values: Sequence[float]) -> Summary | None:
    """The summary of `values`, or None without any."""
    if not len(values):
        return None
    low, middle, high = np.percentile(values, (25, 50, 75))
    return Summary(len(values), float(middle), float(min(values)), float(low), float(high))


def off(values: Sequence[float]) -> float | None:
    """How far the median may be off, as a share of it: the farther end of its 95 % interval.

    With 2 to 5 samples, too few for an interval, the farthest sample; None with one or none, of which nothing is known.
    """
    if len(values) < 2:
        return None
    middle = float(np.median(values))
    low, high = median_interval(values)
    low, high = (min(values), max(values)) if low is None or high is None else (low, high)
    return max(high - middle, middle - low) / middle if middle else 0.0


def noise(wall_s: Sequence[float], cpu_s: Sequence[float], others: float) -> str:
    """What it costs to believe the median of these samples, and why; "" where that is `NOISY` at the most.

    It costs how far the median may be off by chance (`off`); and, where samples were disturbed, how much longer it
    took than the least sample, the one that was disturbed least. A disturbance that changed nothing is no noise, unless
    others took so much of the machine (`MOST_OTHERS`) that no sample can be trusted.
    """
    reasons: list[tuple[float, str]] = []
    few = "" if len(wall_s) >= ENOUGH else f", {len(wall_s)} samples"
    if (error := off(wall_s)) is not None and error > NOISY:
        reasons.append((error, f"samples vary{few}"))
    slower = float(np.median(wall_s)) / min(wall_s) - 1 if len(wall_s) and min(wall_s) > 0 else 0.0
    if slower > NOISY:
        busy = np.asarray(cpu_s) / np.maximum(wall_s, 1e-9)
        starved = int(np.sum(busy < NOISY_CPU * np.median(busy)))
        # CPU clocks tick coarsely on some systems: frames under a millisecond say nothing
        if np.median(wall_s) > 1e-3 and 4 * starved > len(busy):
            text = f"{starved} of {len(busy)} samples got less CPU time than the rest"
            reasons.append((slower, text))
        if others > NOISY_OTHERS:
            reasons.append((slower, f"other processes took {others:.0%} of the machine"))
    if others > MOST_OTHERS:
        return ", ".join(
            (f"off by nobody knows how much: other processes took {others:.0%} of the machine",
             *(text for _, text in reasons if "other processes" not in text))
        )  # fmt: skip
    if not reasons:
        return ""
    cost = max(cost for cost, _ in reasons)
    return f"off by up to {cost:.0%}: {', '.join(text for _, text in reasons)}"


@dataclass(frozen=True)
class Ratio:
    """A ratio of two times, with a 95 % bootstrap interval.

    None with fewer than 6 values: of three, such an interval would hold the true median in 73 of 100 cases, from six on
    it does in 92 to 96.
    """

    n: int
    median: float
    low: float | None
    high: float | None

    @property
    def few(self) -> bool:
        """Are there too few values for an interval?"""
        return self.low is None


def _interval(data: tuple[np.ndarray, ...], statistic: Callable[..., np.ndarray], seed: int):
    options: dict[str, Any] = {
        "n_resamples": RESAMPLES,
        "confidence_level": CONFIDENCE,
        "method": "percentile",
        "vectorized": True,
        "random_state": np.random.default_rng(seed),  # named rng from scipy 1.15 on; both are taken
    }
    result = stats.bootstrap(data, statistic, **options).confidence_interval
    return float(result.low), float(result.high)


def paired_ratio(a: Mapping[int, float], b: Mapping[int, float], seed: int = 0) -> Ratio | None:
    """Median over turns of a / b, both taken in the same turn; None when no turn has both."""
    turns = sorted(set(a) & set(b))
    if not turns:
        return None
    pairs = np.array([a[turn] / b[turn] for turn in turns])
    low = high = None
    if len(pairs) >= ENOUGH:
        low, high = _interval((pairs,), np.median, seed)
    return Ratio(len(pairs), float(np.median(pairs)), low, high)


def unpaired_ratio(a: Sequence[float], b: Sequence[float], seed: int = 0) -> Ratio | None:
    """Median of `a` over median of `b`, from samples taken at different times; None without samples."""
    if not len(a) or not len(b):
        return None

    def statistic(x: np.ndarray, y: np.ndarray, axis: int = -1) -> np.ndarray:
        return np.median(x, axis=axis) / np.median(y, axis=axis)

    low = high = None
    if min(len(a), len(b)) >= ENOUGH:
        low, high = _interval((np.asarray(a), np.asarray(b)), statistic, seed)
    return Ratio(min(len(a), len(b)), float(np.median(a) / np.median(b)), low, high)


def log_slope(x: Sequence[float], y: Sequence[float]) -> tuple[float, float, float] | None:
    """(slope, low, high) of log y against log x, 95 % interval; None with fewer than 2 distinct x.

    With two points the line fits exactly and the interval is the slope itself.
    """
    if len(set(x)) < 2:
        return None
    fit: Any = stats.linregress(np.log(x), np.log(y))
    half = 0.0
    if len(x) > 2:
        half = float(stats.t.ppf(0.5 + CONFIDENCE / 2, len(x) - 2) * fit.stderr)
    return float(fit.slope), float(fit.slope) - half, float(fit.slope) + half
