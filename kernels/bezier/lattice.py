"""The parametric map of a level: virtual vertices on a square grid, and the triangles between them.

```
row 0    0  1  2  3  4     vertex (i, j) is number i (n + 1) + j,  0 <= i, j <= n = 2^level
row 1    5  6  7  8  9     u = i / n, v = j / n
...
```
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Floats, Indices
from lodbench.kernels.bezier.reference import Doubles, bernstein, bernstein_slopes
from lodbench.kernels.launching import LINE

PLANES = 8  # of the map: four of the cubic basis, three of its slope, and t - 1/2


def side_vertices(level: int) -> int:
    """Virtual vertices along a side: 2^level + 1."""
    return (1 << level) + 1


def lattice_parameters(level: int) -> tuple[Doubles, Doubles]:
    """U and v of every virtual vertex, in order: (n + 1)^2 each."""
    t = np.arange(side_vertices(level)) / (1 << level)
    u, v = np.meshgrid(t, t, indexing="ij")
    return u.ravel(), v.ravel()


def stored_map(level: int) -> Floats:
    """The basis at every i / n, (8, stride) float32, padded so that a whole vector may begin at the last.

    The grid is the product of this list with itself. J_{3,i}(t) and J_{3,3-i}(1 - t) are the same number to the bit,
    since both are rounded once: a curve comes out alike from either end.
    """
    side, n = side_vertices(level), 1 << level
    planes = np.zeros((PLANES, -(-side // LINE) * LINE + LINE), np.float32)
    t = np.arange(side) / n  # exact, and so are all products of up to three
    planes[:4, :side] = bernstein(t).T
    planes[4:7, :side] = bernstein_slopes(t).T
    planes[7, :side] = t - 0.5
    return planes


def lattice_triangles(level: int) -> Indices:
    """Two triangles per cell, row by row, (2 * 4^level, 3) uint32, turning from u to v."""
    return grid_triangles(side_vertices(level))


def grid_triangles(side: int) -> Indices:
    """The same of a grid of `side` x `side` vertices."""
    a = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    b, c, d = a + side, a + side + 1, a + 1
    pairs = np.stack([a, b, c, a, c, d], axis=1)
    return pairs.reshape(-1, 3).astype(np.uint32)


def edge_vertices(level: int) -> NDArray[np.int64]:
    """The virtual vertices of each edge of a patch, (4, n + 1): u = 0, u = 1, v = 0, v = 1, along the other one."""
    side = side_vertices(level)
    k, last = np.arange(side), side - 1
    return np.stack([k, last * side + k, k * side, k * side + last])
