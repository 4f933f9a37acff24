"""Where a surface is evaluated along one of its sides: spans between different knots, and places on them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.nurbs_surface import Doubles

Numbers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Samples:
    """Parameters along a side, rising; equal ones would be a fold.

    ```
    spans  (n,) int64     which of the spans that are not empty
    t      (n,) float64   0..1 on it: exact at knots, whatever their numbers
    ```
    """

    spans: Numbers
    t: Doubles

    def __len__(self) -> int:
        return len(self.t)

    def ends(self, last: bool) -> Samples:
        """The first sample alone, or the last."""
        k = -1 if last else 0
        return Samples(self.spans[[k]], self.t[[k]])


def first_knots(knots: Doubles) -> Numbers:
    """The index of the knot at which each span that is not empty begins, (spans,)."""
    return np.flatnonzero(np.diff(knots) > 0)


def numbers(knots: Doubles, samples: Samples) -> Doubles:
    """Samples as the parameters that packages take, (n,)."""
    breaks = np.unique(knots)
    return breaks[samples.spans] + samples.t * np.diff(breaks)[samples.spans]


def by_span(knots: Doubles, segments: int) -> Samples:
    """So many segments on each span."""
    spans = len(first_knots(knots))
    within = np.tile(np.arange(segments) / segments, spans)
    number = np.repeat(np.arange(spans), segments)
    return Samples(np.append(number, spans - 1), np.append(within, 1.0))


def by_side(knots: Doubles, degree: int, segments: int) -> Samples:
    """So many segments on the whole side, even but for these: where the surface may have a crease, at a knot that
    stands there as often as the degree, the nearest sample is moved to it.
    """
    first = first_knots(knots)
    breaks = np.append(knots[first], knots[-1])
    share = np.arange(segments + 1) / segments
    x = breaks[0] + share * (breaks[-1] - breaks[0])
    counts = np.unique(knots, return_counts=True)[1][1:-1]
    taken = np.zeros(segments + 1, bool)
    taken[[0, -1]] = True
    for crease in breaks[1:-1][counts >= degree]:
        free = np.flatnonzero(~taken)
        if len(free):
            k = free[np.abs(x[free] - crease).argmin()]
            x[k], taken[k] = crease, True
    x = np.sort(x)
    x[-1] = breaks[-1]
    spans = np.clip(np.searchsorted(breaks, x, "right") - 1, 0, len(first) - 1)
    return Samples(spans, (x - breaks[spans]) / np.diff(breaks)[spans])
