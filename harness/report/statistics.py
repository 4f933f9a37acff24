"""What samples say: summaries, ratios taken pair by pair, slopes, noise."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats

from lodbench.harness.measure.timing import SAMPLES, SLOW_SAMPLES

NOISY_MEDIAN = 0.03  # standard error of a noisy row's median, relative to it
NOISY_CPU = (
    0.75  # a sample whose CPU time per wall time is below this share of the subject's median
)
NOISY_OTHERS = 0.15  # share of the machine's CPU time taken by other processes during the group

RESAMPLES = 2000  # of a bootstrap
CONFIDENCE = 0.95


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


def uncertainty(values: Sequence[float]) -> float:
    """Relative standard error of the median, from a robust standard deviation (1.4826 x MAD), as for normal noise."""
    middle = float(np.median(values))
    deviation = 1.4826 * float(stats.median_abs_deviation(values))
    return 1.2533 * deviation / np.sqrt(len(values)) / middle if middle else 0.0


def noise(wall_s: Sequence[float], cpu_s: Sequence[float], others: float) -> str:
    """Why these samples are noisy, or "" when they are not."""
    reasons = []
    if len(wall_s) > 1 and (error := uncertainty(wall_s)) > NOISY_MEDIAN:
        reasons.append(f"median uncertain by {error:.0%}")
    busy = np.asarray(cpu_s) / np.maximum(wall_s, 1e-9)
    starved = int(np.sum(busy < NOISY_CPU * np.median(busy))) if len(busy) else 0
    # CPU clocks tick coarsely on some systems: frames under a millisecond say nothing
    if len(wall_s) and np.median(wall_s) > 1e-3 and 4 * starved > len(busy):
        reasons.append(f"{starved} of {len(busy)} samples got less CPU time than the rest")
    if others > NOISY_OTHERS:
        reasons.append(f"other processes took {others:.0%} of the machine")
    return ", ".join(reasons)


@dataclass(frozen=True)
class Ratio:
    """A ratio of two times, with a 95 % bootstrap interval (None with fewer than 3 values)."""

    n: int
    median: float
    low: float | None
    high: float | None


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
    if len(pairs) >= SLOW_SAMPLES:
        low, high = _interval((pairs,), np.median, seed)
    return Ratio(len(pairs), float(np.median(pairs)), low, high)


def unpaired_ratio(a: Sequence[float], b: Sequence[float], seed: int = 0) -> Ratio | None:
    """Median of `a` over median of `b`, from samples taken at different times; None without samples."""
    if not len(a) or not len(b):
        return None

    def statistic(x: np.ndarray, y: np.ndarray, axis: int = -1) -> np.ndarray:
        return np.median(x, axis=axis) / np.median(y, axis=axis)

    low = high = None
    if min(len(a), len(b)) >= SLOW_SAMPLES:
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
