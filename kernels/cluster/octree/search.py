"""How fine must the finest cells be, and which threshold leaves at most so many triangles? Halving finds the latter."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from lodbench.kernels.cluster.octree.params import MAX_LEVELS
from lodbench.kernels.cluster.survivors import DeviceSurvivors
from lodbench.kernels.cluster.upload import Upload
from lodbench.kernels.targets import CLOSE

FINER = 2.0  # finest cells along an axis for each of a uniform grid with as many triangles
MOST_CELLS = 1 << MAX_LEVELS

NOTHING_MERGES = np.float32(-1)


def uniform_cells(upload: Upload, target: int) -> float:
    """Cells along the longest box edge of about the uniform grid that leaves so many triangles."""
    with upload.setup.host("search"):
        extents = upload.high - upload.low
        x, y, z = extents / max(float(extents.max()), 1e-300)
        area = max(1.4 * (x * y + y * z + z * x), 0.05)
        cells = max(math.sqrt(max(target, 1) / (2.4 * area)), 2.0)
        count = DeviceSurvivors(
            upload.device, upload.program, upload.positions, upload.triangles, upload.box
        )
        for _ in range(3):
            left = count(min(cells, MOST_CELLS))
            off = math.sqrt(target / left) if left else 2.0
            cells = min(max(cells * off, 1.0), float(MOST_CELLS))
            if 0.8 < off < 1.25:
                break
        return cells


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
