"""The uniform grid over a mesh's box: which cell a position falls in, bit for bit as the kernels decide it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.parameters import shown

MAX_CELLS = 2**27
FLAT = 2.0**-100  # of the largest cell edge: along a flatter axis all is in the first cell

Cells = int | float | tuple[int, int, int]


def check_cells(cells: Any) -> None:
    """Refuse anything but a real number of cells along the longest axis, or three counts.

    Raises:
        TypeError: not numbers.
        ValueError: below 1, not finite, not three, or more than 2**27 in all.
    """
    many = isinstance(cells, tuple | list)
    values = tuple(cells) if many else (cells,)
    for value in values:
        if isinstance(value, bool) or not isinstance(value, int | float | np.number):
            raise TypeError(f"cells: expected a number or (nx, ny, nz), got {shown(cells)}")
        if not 1 <= value < math.inf or (many and value != int(value)):
            raise ValueError(f"cells: expected at least 1 per axis, got {shown(cells)}")
    if many and len(values) != 3:
        raise ValueError(f"cells: expected a number or (nx, ny, nz), got {shown(cells)}")
    check_product([math.ceil(value) for value in values], cells)


def check_product(counts: list[int] | tuple[int, ...], cells: object) -> None:
    """Refuse a grid of more than 2**27 cells."""
    if math.prod(counts) > MAX_CELLS:
        product = " x ".join(f"{n:,}" if n <= MAX_CELLS else "more" for n in counts)
        raise ValueError(
            f"cells: expected at most {MAX_CELLS:,} in all, got {product} ({shown(cells)})"
        )


@dataclass(frozen=True)
class Grid:
    """A grid of `counts` cells that starts at the box's lower corner.

    A position p in model units becomes q = (p * prescale - low) * inverse, float32, in units of the largest cell
    edge; its cell along an axis is trunc(q * per_axis), cut to 0 .. count - 1, and the linear number is
    (z * ny + y) * nx + x.
    `prescale` is a power of two that brings the box near 1, so that no scale over- or underflows; multiplying by it
    is exact, which is why the host and every device decide alike.

    Attributes:
        counts: cells along x, y, z.
        prescale: a power of two.
        low: box corner times prescale, float32 (3,).
        inverse: units per prescaled model unit, float32.
        unit: prescaled model units per unit, float32.
        per_axis: cells per unit along x, y, z, float32 (3,); 1 for cubic cells, 0 along a flat axis, which is one with
            cells thinner than 2^-100 of the largest edge.
        extent: the longest box edge in units.
    """

    counts: tuple[int, int, int]
    prescale: float
    low: NDArray[np.float32]
    inverse: np.float32
    unit: np.float32
    per_axis: NDArray[np.float32]
    extent: float

    @classmethod
    def over(cls, low: NDArray[np.floating], high: NDArray[np.floating], cells: Cells) -> Grid:
        """The grid over the box from `low` to `high`, (3,) model units.

        Args:
            low: lower corner.
            high: upper corner.
            cells: cubic cells along the longest axis (a real number: the last cell is then cut), or (nx, ny, nz).

        Raises:
            TypeError, ValueError: see `check_cells`; also when cubic cells make more than 2**27 in all.
        """
        check_cells(cells)
        corner, far = [float(b) for b in low], [float(h) for h in high]
        extents = [h - b for b, h in zip(corner, far, strict=True)]
        longest = max(extents)
        if isinstance(cells, tuple | list):
            counts = tuple(int(n) for n in cells)
            edges = [extent / n for extent, n in zip(extents, counts, strict=True)]
        else:
            edge = longest / float(cells)
            # ceil of a quotient that is whole but for its rounding would add a layer that no vertex reaches
            counts = tuple(
                max(1, math.ceil(extent / longest * float(cells) - 1e-9)) if longest > 0 else 1
                for extent in extents
            )
            check_product(counts, cells)
            edges = [edge if extent > 0 else 0.0 for extent in extents]
        unit = max(edges) or 1.0
        reach = max(map(abs, (*corner, *far, longest, 1e-45)))
        exponent = min(-math.frexp(longest)[1] if longest > 0 else 0, 126 - math.frexp(reach)[1])
        prescale = math.ldexp(1.0, max(-126, min(126, exponent)))
        scaled = unit * prescale
        return cls(
            counts=counts,  # type: ignore[arg-type]
            prescale=prescale,
            # of -0 and 0, which are equal, a box has either: 0
            low=np.array([b * prescale + 0.0 for b in corner], np.float32),
            inverse=np.float32(min(1.0 / scaled, 3e38)),
            unit=np.float32(scaled),
            per_axis=np.array([unit / e if e > FLAT * unit else 0.0 for e in edges], np.float32),
            extent=longest / unit,
        )

    @property
    def cell_count(self) -> int:
        """Cells in all, occupied or not."""
        return math.prod(self.counts)

    @property
    def arguments(self) -> dict[str, tuple[Any, ...]]:
        """What a kernel that calls `common/grid.cl` is given."""
        return {
            "low": (*self.low, self.prescale),
            "per_axis": (*self.per_axis, self.inverse),
            "cells": (*self.counts, 0),
        }

    @property
    def edge(self) -> float:
        """The largest cell edge, model units."""
        return float(self.unit) / self.prescale

    def rounding(self, positions: NDArray[np.float32]) -> float:
        """What rounding moves such positions by, cells: the box may lie far from zero."""
        return 4 * float(np.spacing(np.abs(positions).max(initial=0))) / self.edge

    def points(self, positions: NDArray[np.float32]) -> NDArray[np.float32]:
        """Positions (n, 3) float32 in units of the largest cell edge from the box corner, as the kernels round them."""
        return (positions * np.float32(self.prescale) - self.low) * self.inverse

    def cells_of(self, points: NDArray[np.float32]) -> NDArray[np.int64]:
        """The linear cell number of each of `points`, (n,) int64."""
        steps = (points * self.per_axis).astype(np.int64)
        x, y, z = np.clip(steps, 0, np.array(self.counts) - 1).T
        return (z * self.counts[1] + y) * self.counts[0] + x

    def positions(self, points: NDArray[np.floating]) -> NDArray[np.float32]:
        """Points back in model units, (n, 3) float32."""
        scaled = points.astype(np.float64) * float(self.unit) + self.low
        return np.clip(scaled / self.prescale, -3.4e38, 3.4e38).astype(np.float32)
