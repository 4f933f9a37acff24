"""How well the median of some samples is known, with no word on how they are distributed; when to stop taking them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from scipy import stats

CONFIDENCE = 0.95
ENOUGH = 6  # samples below which no two of them hold the median between them with this confidence


@cache
def _rank(n: int) -> int:
    """The k for which the k-th least and the k-th largest of n hold the median, with the confidence or more."""
    return int(stats.binom.ppf((1 - CONFIDENCE) / 2, n, 0.5))


def median_interval(values: Sequence[float]) -> tuple[float, float] | tuple[None, None]:
    """The two samples between which the true median lies, in 95 of 100 cases or more; None with fewer than 6 samples.

    Of any distribution: each sample is above its median with the chance of a coin, whatever else holds.

    Source: Thompson 1936, On Confidence Ranges for the Median; David & Nagaraja 2003, Order Statistics, section 7.1.
    """
    if len(values) < ENOUGH:
        return None, None
    ordered, k = sorted(values), _rank(len(values))
    return float(ordered[k - 1]), float(ordered[-k])


def half_width(values: Sequence[float]) -> float:
    """Half the interval of the median over the middle of it; infinite with too few samples."""
    low, high = median_interval(values)
    if low is None or high is None:
        return float("inf")
    return (high - low) / (high + low) if high + low else 0.0
