"""Which grid leaves at most so many triangles, and hardly fewer? Found by counting alone, for any clustering."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.cluster.grid import MAX_CELLS
from lodbench.kernels.targets import CLOSE

_SAMPLE = 1 << 16  # triangles of a first, rough count
_MOST_COUNTS = 60

Count = Callable[[float, int], int]
"""(cells along the longest axis, stride) -> triangles left of every `stride`-th one of the input."""


@dataclass(frozen=True)
class Found:
    """What a search settled on.

    Attributes:
        cells: real number of cubic cells along the longest axis; None: the mesh itself, for no grid comes nearer.
        triangles: how many are left; more than `target` only where every grid with fewer leaves none at all.
        target: what was asked for.
        counts: full counting passes made.
    """

    cells: float | None
    triangles: int
    target: int
    counts: int

    @property
    def met(self) -> bool:
        """At most `target` triangles, and at least 95 % of them?"""
        return CLOSE * self.target <= self.triangles <= self.target

    @property
    def gap(self) -> int:
        """Triangles short of the target; negative where there are more."""
        return self.target - self.triangles


def find_cells(
    count: Count,
    extents: NDArray[np.floating],
    triangle_count: int,
    target: int,
    most_cells: int = MAX_CELLS,
) -> Found:
    """The grid of cubic cells that leaves at most `target` triangles and at least 95 % of them.

    The cell edge is a real number, so almost any count can be hit; where the mesh allows none (a flat lattice, a
    handful of triangles), the grid with the most below the target. Where each of those leaves nothing, the grid with
    the fewest that was found, though they are more than was asked for; and the mesh itself where grids leave all of
    it or nothing, or where all of it was asked for.

    Args:
        count: how many triangles a grid leaves.
        extents: edges of the mesh's box, (3,).
        triangle_count: the mesh's.
        target: triangles wanted at most.
        most_cells: cells of the finest grid, in all.

    Raises:
        ValueError: a negative target.
    """
    if target < 0:
        raise ValueError(f"target_count: expected at least 0, got {target}")
    if not triangle_count or not target:
        return Found(1.0, 0, target, 0)
    if target >= triangle_count:
        return Found(None, triangle_count, target, 0)
    return _Search(count, extents, triangle_count, target, most_cells).run()


class _Search:
    """Counts, and where they led so far."""

    def __init__(
        self, count: Count, extents: NDArray[np.floating], triangles: int, target: int, most: int
    ) -> None:
        self._counted = count
        self._extents = extents
        self._triangles = triangles
        self._target = target
        self._most = self._most_along(most)
        self._full = 0

    def _count(self, cells: float, stride: int) -> int:
        """Triangles left on the grid of `cells`; an estimate from every `stride`-th one."""
        self._full += stride == 1
        found = self._counted(cells, stride)
        return (
            found if stride == 1 else round(found * self._triangles / -(-self._triangles // stride))
        )

    def _most_along(self, most: int) -> float:
        """The finest grid of cubic cells: `most` in all, for a box this long."""
        longest = float(self._extents.max())
        if longest <= 0:
            return 1.0
        low, high = 1.0, float(most)
        for _ in range(60):
            middle = math.sqrt(low * high)
            cells = math.prod(max(1, math.ceil(e / longest * middle - 1e-9)) for e in self._extents)
            low, high = (middle, high) if cells <= most else (low, middle)
        return low

    def _guess(self) -> float:
        """Cells for a surface like its box's: two triangles for each of 1.2 cells per cell edge squared."""
        x, y, z = self._extents / max(float(self._extents.max()), 1e-300)
        area = max(1.4 * (x * y + y * z + z * x), 0.05)
        return math.sqrt(self._target / (2.4 * area))

    def run(self) -> Found:
        """A rough search on a sample, then full counts from where it led."""
        cells = min(max(self._guess(), 1.0), self._most)
        stride = max(1, self._triangles // _SAMPLE)
        if stride > 1:
            (cells, _), _ = self._bracket(cells, stride, 0.96, 0.99, 8)
        (cells, left), above = self._bracket(cells, 1, CLOSE, 1.0, _MOST_COUNTS)
        if left:
            return Found(cells, left, self._target, self._full)
        return Found(*(above or (None, self._triangles)), self._target, self._full)

    def _bracket(
        self, cells: float, stride: int, least: float, limit: float, tries: int
    ) -> tuple[tuple[float, int], tuple[float, int] | None]:
        """Cells and triangles, between `least` and `limit` of the target where found; else the most below `limit`.

        With it the fewest above `limit` that are fewer than all, None where there were none. Triangles grow about as
        the square of the cells along an axis; next to a bracket that is too coarse and one that is too fine, the next
        guess lies between them by that law, every third one in the middle.
        """
        target = self._target
        aim = 0.5 * (least + limit) * target
        best = below = (1.0, 0)  # one cell: nothing is left
        above: tuple[float, int] | None = None
        fewest: tuple[float, int] | None = None
        stuck = 0
        for turn in range(tries):
            count = self._count(cells, stride)
            if count <= limit * target:
                stuck = 0 if count > best[1] else stuck + 1
                best = max(best, (cells, count), key=lambda found: found[1])
                below = (cells, count)
            else:
                above = (cells, count)
                if count < (fewest[1] if fewest else self._triangles):
                    fewest = above
            if least * target <= count <= limit * target:
                break
            ratio = math.sqrt(aim / max(count, 1))
            if above is None:
                # all there is to be left is, or nothing more comes: a finer grid is of no use
                if cells >= self._most or count >= self._triangles or stuck > 4:
                    break
                cells = min(cells * min(max(ratio, 1.1), 2.0), self._most)
                continue
            span = math.log(above[0] / below[0])
            if span < 1e-7:
                break
            share = 0.5
            if turn % 3 < 2 and below[1] > 0:
                share = math.log(aim / below[1]) / math.log(above[1] / below[1])
            elif turn % 3 < 2:
                share = 1 - math.log(math.sqrt(above[1] / aim)) / span
            cells = below[0] * math.exp(span * min(max(share, 0.02), 0.98))
        return best, fewest
