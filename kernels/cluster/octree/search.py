"""Which threshold leaves at most so many triangles? Merging brings no triangle back, so halving finds it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lodbench.kernels.targets import CLOSE

NOTHING_MERGES = np.float32(-1)


def find_limit(count: Callable[[float], int], target: int, most: float) -> tuple[float, int, int]:
    """The threshold, the triangles that it leaves, and how often was counted.

    Of at most `target` triangles it leaves at least 95 %, else as many as any threshold below the target does, or the
    fewest above it where each of those leaves none; the finest cells where they leave no more.

    Args:
        count: threshold -> triangles left; never rises with it, but for a few in a table with collisions.
        target: triangles wanted at most.
        most: the largest error of a node.
    """
    finest = count(float(NOTHING_MERGES))
    if finest <= target:
        return float(NOTHING_MERGES), finest, 1
    # floats from 0 up order as their bits do
    fewest = (float(NOTHING_MERGES), finest)
    low, high = -1, int(np.float32(most).view(np.int32))
    best = (most, count(float(np.float32(most))))
    made = 2
    while high - low > 1 and best[1] < CLOSE * target:
        middle = (low + high) // 2
        limit = float(np.int32(middle).view(np.float32))
        left, made = count(limit), made + 1
        if left <= target:
            high = middle
            best = max(best, (limit, left), key=lambda found: found[1])
        else:
            low, fewest = middle, (limit, left)
    return *(best if best[1] or not target else fewest), made
