"""The raster stage pixel by pixel in whole numbers, written for reading: what tests compare the kernels with.

Coverage is exact (Python integers); depth repeats the kernels' float32 operations in their order, so keys are equal to
the bit on devices whose float32 division is exact. Clipping repeats the kernels' cuts. For images of a few thousand
pixels.

Source: Pineda 1988, "A parallel algorithm for polygon rasterization"; Sutherland & Hodgman 1974 for clipping.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

SUBPIXELS = 256
GUARD = np.float32(1 << 22)
EMPTY_ID = 0xFFFFFFFF
F = np.float32

Corner = tuple[int, int, np.float32]  # x, y in sub-pixels, depth


def transform(positions: NDArray[np.float32], matrix: NDArray[np.float32]) -> NDArray[np.float32]:
    """x, y (sub-pixels), depth and w, all times w: (n, 4) float32, each row ((m0 x + m1 y) + m2 z) + m3."""
    p, m = positions.astype(F), matrix.reshape(4, 4).astype(F)
    return np.stack(
        [((m[r, 0] * p[:, 0] + m[r, 1] * p[:, 1]) + m[r, 2] * p[:, 2]) + m[r, 3] for r in range(4)],
        axis=1,
    )


def place(corner: NDArray[np.float32]) -> Corner:
    """A corner in front of the eye, snapped to whole sub-pixels."""
    inverse = F(1) / corner[3]
    x = min(max(corner[0] * inverse, -GUARD), GUARD)
    y = min(max(corner[1] * inverse, -GUARD), GUARD)
    z = max(corner[2] * inverse, F(0)) + F(0)
    return int(np.floor(F(x) + F(0.5))), int(np.floor(F(y) + F(0.5))), F(z)


def distances(corner: NDArray[np.float32]) -> list[np.float32]:
    """To the near plane and to the four of the guard band; negative is outside."""
    x, y, z, w = corner
    return [z, x + GUARD * w, GUARD * w - x, y + GUARD * w, GUARD * w - y]


def clip(corners: list[NDArray[np.float32]]) -> list[NDArray[np.float32]]:
    """The polygon that is left of a triangle, cut edge by edge from its inside end."""
    for plane in range(5):
        kept = []
        for k, a in enumerate(corners):
            b = corners[(k + 1) % len(corners)]
            da, db = distances(a)[plane], distances(b)[plane]
            if da >= 0:
                kept.append(a)
            if (da >= 0) != (db >= 0):
                kept.append(
                    a + (b - a) * (da / (da - db)) if da >= 0 else b + (a - b) * (db / (db - da))
                )
        corners = kept
        if len(corners) < 3:
            return []
    return corners if all(c[3] > 0 for c in corners) else []


def fragments(
    a: Corner, b: Corner, c: Corner, width: int, height: int, cull: bool = False
) -> Iterator[tuple[int, int, np.float32]]:
    """(column, row, depth) of each pixel whose centre lies in the triangle, or on its left or top edges."""
    area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
    if area == 0 or (cull and area > 0):
        return
    ring = (a, b, c, a) if area > 0 else (a, c, b, a)
    edges = []
    for p, q in pairwise(ring):
        dx, dy = q[0] - p[0], q[1] - p[1]
        owned = dy < 0 or (dy == 0 and dx > 0)
        edges.append((p[0], p[1], dx, dy, 0 if owned else 1))
    one = F(1) / F(area)
    x1, y1, z1 = F(b[0] - a[0]), F(b[1] - a[1]), b[2] - a[2]
    x2, y2, z2 = F(c[0] - a[0]), F(c[1] - a[1]), c[2] - a[2]
    zx, zy = (z1 * y2 - z2 * y1) * one, (z2 * x1 - z1 * x2) * one
    near, far = min(a[2], b[2], c[2]), max(a[2], b[2], c[2])
    xs, ys = [p[0] for p in ring], [p[1] for p in ring]
    half = SUBPIXELS // 2
    for row in range(max((min(ys) + half - 1) >> 8, 0), min((max(ys) - half) >> 8, height - 1) + 1):
        y = row * SUBPIXELS + half
        for column in range(
            max((min(xs) + half - 1) >> 8, 0), min((max(xs) - half) >> 8, width - 1) + 1
        ):
            x = column * SUBPIXELS + half
            if all(dx * (y - py) - dy * (x - px) >= least for px, py, dx, dy, least in edges):
                z = (a[2] + zx * F(x - a[0])) + zy * F(y - a[1])
                yield column, row, F(min(max(z, near), far))


def draw(
    positions: NDArray[np.float32],
    triangles: NDArray[np.uint32],
    matrix: NDArray[np.float32],
    width: int,
    height: int,
    cull: bool = False,
) -> tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.int64]]:
    """Depth, triangle id and number of fragments of each pixel, (height, width) each.

    Args:
        positions: (n, 3) float32, model units.
        triangles: (m, 3), rows of positions.
        matrix: (16,) float32, of `camera.to_screen`.
        width: pixels.
        height: pixels.
        cull: leave out triangles that face away.
    """
    depths = np.ones((height, width), F)
    ids = np.full((height, width), EMPTY_ID, np.uint32)
    counts = np.zeros((height, width), np.int64)
    with np.errstate(all="ignore"):
        corners = transform(positions, matrix)
        for number, triangle in enumerate(triangles):
            polygon = [corners[v] for v in triangle]
            if not all(d >= 0 for c in polygon for d in distances(c)) or not all(
                c[3] > 0 for c in polygon
            ):
                polygon = clip(polygon)
            placed = [place(c) for c in polygon]
            for k in range(2, len(placed)):
                for column, row, z in fragments(
                    placed[0], placed[k - 1], placed[k], width, height, cull
                ):
                    counts[row, column] += 1
                    old = (depths[row, column], ids[row, column])
                    if z <= 1 and (z, number) < old:
                        depths[row, column], ids[row, column] = z, number
    return depths, ids, counts
