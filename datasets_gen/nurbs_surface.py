"""NURBS surfaces: checked, clamped and frozen, host side only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lodbench.datasets_gen.arrays import Origin, box, middle

Doubles = NDArray[np.float64]

LARGEST_DEGREE = 7
SAME_KNOT = 1e-13
"""Of the whole range of knots: two that are nearer are one, parted by roundings of whoever wrote them."""


@dataclass(frozen=True, eq=False)
class NurbsSurface:
    """One tensor-product NURBS surface, clamped: what comes unclamped gets the knots that it lacks, exactly.

    ```
    points   (n_u, n_v, 3) float64   Cartesian, not multiplied by the weights
    weights  (n_u, n_v)    float64   positive
    knots_u  (n_u + degree_u + 1,) float64, non-decreasing, inner ones at most degree_u times; knots_v alike
    ```
    `weights` of None are ones. The arrays are read-only.

    Raises:
        TypeError: a dtype that is not a number's.
        ValueError: a degree that is not 1 to 7, counts that do not fit, knots that fall, NaN, weights not positive.
    """

    degree_u: int
    degree_v: int
    knots_u: Doubles
    knots_v: Doubles
    points: Doubles
    weights: Doubles = None  # pyright: ignore[reportAssignmentType]

    if TYPE_CHECKING:

        def __init__(
            self,
            degree_u: int,
            degree_v: int,
            knots_u: ArrayLike,
            knots_v: ArrayLike,
            points: ArrayLike,
            weights: ArrayLike | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        points = _numbers("points", self.points)
        if points.ndim != 3 or points.shape[2] != 3:
            raise ValueError(f"points: expected (n_u, n_v, 3) float64, got shape {points.shape}")
        given = np.ones(points.shape[:2]) if self.weights is None else self.weights
        weights = _numbers("weights", given)
        if weights.shape != points.shape[:2]:
            raise ValueError(f"weights: expected shape {points.shape[:2]}, got {weights.shape}")
        if not (weights > 0).all():
            raise ValueError(f"weights: expected positive numbers, got {weights.min():g}")
        homogeneous = np.concatenate([points * weights[..., None], weights[..., None]], axis=2)
        changed = False
        for axis, side in enumerate("uv"):
            degree = _checked_degree(f"degree_{side}", getattr(self, f"degree_{side}"))
            knots = _numbers(f"knots_{side}", getattr(self, f"knots_{side}"))
            name, rows = f"knots_{side}", homogeneous.shape[axis]
            _check_knots(name, knots, degree, rows, points.shape[axis])
            knots = _snapped(knots)
            ends = float(knots[degree]), float(knots[rows])
            if not (ends[0] < ends[1]):
                raise ValueError(
                    f"{name}: expected a range that is not empty, got {ends[0]:g} to {ends[1]:g}"
                )
            if not _clamped(knots, degree):
                changed = True
                homogeneous = np.moveaxis(homogeneous, axis, 0)
                knots, homogeneous = cut(knots, homogeneous, degree, *ends)
                homogeneous = np.moveaxis(homogeneous, 0, axis)
            _check_multiplicity(name, knots, degree)
            object.__setattr__(self, f"degree_{side}", degree)
            object.__setattr__(self, name, _kept(knots))
        if changed:
            weights = homogeneous[..., 3]
            points = homogeneous[..., :3] / weights[..., None]
        object.__setattr__(self, "points", _kept(points))
        object.__setattr__(self, "weights", _kept(weights))

    @property
    def rational(self) -> bool:
        """Are its weights not all one number?"""
        return bool(np.ptp(self.weights) > 0)

    @property
    def spans(self) -> tuple[Doubles, Doubles]:
        """The different knots along u and along v: a KSQuad lies between two of each."""
        return np.unique(self.knots_u), np.unique(self.knots_v)

    @property
    def span_count(self) -> int:
        """Its KSQuads: the knot rectangles that are not empty."""
        along_u, along_v = self.spans
        return (len(along_u) - 1) * (len(along_v) - 1)

    def within(self, low_u: float, high_u: float, low_v: float, high_v: float) -> NurbsSurface:
        """The part between these parameters, exactly; those outside its own range are drawn in."""
        own = self.knots_u, self.knots_v
        ranges = (low_u, high_u), (low_v, high_v)
        homogeneous = np.concatenate(
            [self.points * self.weights[..., None], self.weights[..., None]], axis=2
        )
        made = []
        for axis, (knots, degree, (low, high)) in enumerate(
            zip(own, (self.degree_u, self.degree_v), ranges, strict=True)
        ):
            ends = max(low, knots[0]), min(high, knots[-1])
            if not ends[0] < ends[1]:
                raise ValueError(f"range: expected low below high, got {low:g} to {high:g}")
            homogeneous = np.moveaxis(homogeneous, axis, 0)
            knots, homogeneous = cut(knots, homogeneous, degree, *ends)
            homogeneous = np.moveaxis(homogeneous, 0, axis)
            made.append(knots)
        weights = homogeneous[..., 3]
        return replace(
            self, knots_u=made[0], knots_v=made[1], weights=weights,
            points=homogeneous[..., :3] / weights[..., None],
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class NurbsModel:
    """A set of NURBS surfaces, untrimmed.

    Attributes:
        surfaces: in the order of their file.
        names: one for each surface; `surface_0` and so on where there are none.
        notes: what a file has that is not here, such as trims, a line each.
    """

    surfaces: tuple[NurbsSurface, ...]
    names: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        surfaces = tuple(self.surfaces)
        for surface in surfaces:
            if not isinstance(surface, NurbsSurface):
                raise TypeError(f"surfaces: expected NurbsSurface, got {type(surface).__name__}")
        object.__setattr__(self, "surfaces", surfaces)
        object.__setattr__(self, "names", _distinct(self.names, len(surfaces)))
        object.__setattr__(self, "notes", tuple(self.notes))

    @property
    def span_count(self) -> int:
        """KSQuads of all surfaces."""
        return sum(surface.span_count for surface in self.surfaces)

    @property
    def box(self) -> tuple[Doubles, Doubles]:
        """Lower and upper corner of all control points, which the surfaces lie between, (3,) each."""
        nets = [surface.points.reshape(-1, 3) for surface in self.surfaces]
        return box(np.concatenate([np.zeros((0, 3)), *nets]))

    @property
    def diagonal(self) -> float:
        low, high = self.box
        return float(np.linalg.norm(high - low))

    def recentred(self) -> tuple[NurbsModel, Origin | None]:
        """The model about an origin in its middle on each axis where it lies far from zero; see `arrays.recentred`."""
        origin = middle(*self.box)
        if origin is None:
            return self, None
        moved = tuple(replace(s, points=s.points - origin) for s in self.surfaces)
        return replace(self, surfaces=moved), origin


def cut(
    knots: Doubles, rows: Doubles, degree: int, low: float, high: float
) -> tuple[Doubles, Doubles]:
    """Knots and rows of control points of the part from `low` to `high`, clamped there.

    Args:
        knots: (n + degree + 1,).
        rows: (n, ...) homogeneous.
        degree: of the curve, or of the surface along its first axis.
        low: a parameter of the curve.
        high: another.

    Source: Boehm 1980, knot insertion: the curve stays as it is.
    """
    for end in (low, high):
        knots, rows = _with_knot(knots, rows, degree, end)
    whole = degree + 1
    there = [min(int((knots == end).sum()), whole) for end in (low, high)]
    first = int(np.searchsorted(knots, low, "right")) - there[0]
    last = int(np.searchsorted(knots, high, "left")) + there[1]
    before, after = (
        whole - there[0],
        whole - there[1],
    )  # a clamped end's outermost knot weighs nothing
    made = np.concatenate([np.full(before, low), knots[first:last], np.full(after, high)])
    start = first - before
    return made, rows[start : start + len(made) - whole]


def _with_knot(knots: Doubles, rows: Doubles, degree: int, at: float) -> tuple[Doubles, Doubles]:
    """The same curve with a knot `at` that stands there `degree` times at the least."""
    for there in range(int((knots == at).sum()), degree):
        span = int(np.searchsorted(knots, at, "right")) - 1
        i = np.arange(span - degree + 1, span - there + 1)
        share = (at - knots[i]) / (knots[i + degree] - knots[i])
        share = share.reshape(-1, *[1] * (rows.ndim - 1))
        mixed = share * rows[i] + (1 - share) * rows[i - 1]
        rows = np.concatenate([rows[: span - degree + 1], mixed, rows[span - there :]])
        knots = np.insert(knots, span + 1, at)
    return knots, rows


def _numbers(name: str, values: object) -> Doubles:
    try:
        array = np.array(values, np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: expected numbers in rows of one length, got others") from None
    if not np.isfinite(array).all():
        raise ValueError(f"{name}: expected finite numbers, got NaN or infinity")
    return array


def _kept(array: Doubles) -> Doubles:
    array = np.ascontiguousarray(array)
    array.flags.writeable = False
    return array


def _checked_degree(name: str, degree: object) -> int:
    if not isinstance(degree, int | np.integer) or isinstance(degree, bool):
        raise TypeError(f"{name}: expected a whole number, got {degree!r}")
    if not 1 <= degree <= LARGEST_DEGREE:
        raise ValueError(f"{name}: expected 1 to {LARGEST_DEGREE}, got {degree}")
    return int(degree)


def _check_knots(name: str, knots: Doubles, degree: int, rows: int, points: int) -> None:
    if rows <= degree:
        raise ValueError(
            f"points: expected more than {degree} along {name[-1]} for that degree, got {points}"
        )
    if knots.shape != (rows + degree + 1,):
        raise ValueError(
            f"{name}: expected {rows + degree + 1} knots for {points} points of degree {degree}, "
            f"got {knots.size if knots.ndim == 1 else f'shape {knots.shape}'}"
        )
    falls = np.flatnonzero(np.diff(knots) < -SAME_KNOT * np.ptp(knots))
    if len(falls):
        k = int(falls[0])
        raise ValueError(
            f"{name}: expected knots that do not fall, got {knots[k]:g} before {knots[k + 1]:g}"
        )


def _snapped(knots: Doubles) -> Doubles:
    """Knots that differ by roundings alone made equal, to the first of them."""
    apart = np.diff(knots) > SAME_KNOT * (knots[-1] - knots[0])
    group = np.concatenate([[0], np.cumsum(apart)])
    first = np.concatenate([[0], np.flatnonzero(apart) + 1])
    return knots[first[group]]


def _clamped(knots: Doubles, degree: int) -> bool:
    """Does each end stand there as often as the degree and once more?"""
    ends = (knots, knots[::-1])
    return all(k[0] == k[degree] and k[degree] != k[degree + 1] for k in ends)


def _check_multiplicity(name: str, knots: Doubles, degree: int) -> None:
    values, counts = np.unique(knots[degree + 1 : -degree - 1], return_counts=True)
    if len(counts) and counts.max() > degree:
        k = int(counts.argmax())
        raise ValueError(
            f"{name}: expected an inner knot at most {degree} times, where the surface holds together, "
            f"got {values[k]:g} {counts[k]} times"
        )


def _distinct(names: Sequence[str], count: int) -> tuple[str, ...]:
    """A name for each surface, none twice."""
    if names and len(names) != count:
        raise ValueError(f"names: expected {count}, got {len(names)}")
    found: dict[str, None] = {}
    for k in range(count):
        name = str(names[k]) if names and names[k] else f"surface_{k}"
        while name in found:
            name = f"{name}_{k}"
        found[name] = None
    return tuple(found)
