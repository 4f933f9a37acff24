"""A curve through the cells of a grid, on which triangles that follow each other are near each other."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray


def first_of(bits: int) -> int:
    """Where the curve through 8**bits cells begins in `hilberts`."""
    return (8**bits - 1) // 7


@cache
def hilberts(bits: int) -> NDArray[np.uint32]:
    """`hilbert` of 0 to `bits`, one after the other."""
    return np.concatenate([hilbert(b) for b in range(bits + 1)])


@cache
def hilbert(bits: int) -> NDArray[np.uint32]:
    """The place of each cell along Hilbert's curve, (8**bits,), cells in the order of x, y, z, the last fastest.

    Source: Skilling 2004, Programming the Hilbert curve.
    """
    if bits == 0:
        return np.zeros(1, np.uint32)
    side = np.arange(1 << bits, dtype=np.uint32)
    x = np.stack(np.meshgrid(side, side, side, indexing="ij")).reshape(3, -1)
    q = 1 << (bits - 1)
    while q > 1:  # undo excess work
        for i in range(3):
            up = (x[i] & q) != 0
            exchange = np.where(up, 0, (x[0] ^ x[i]) & (q - 1))
            x[0] ^= np.where(up, q - 1, exchange).astype(np.uint32)
            if i:
                x[i] ^= exchange.astype(np.uint32)
        q >>= 1
    x[1] ^= x[0]  # Gray code
    x[2] ^= x[1]
    turned = np.zeros_like(x[0])
    q = 1 << (bits - 1)
    while q > 1:
        turned ^= np.where(x[2] & q, q - 1, 0).astype(np.uint32)
        q >>= 1
    x ^= turned
    place = np.zeros_like(x[0])
    for bit in range(bits - 1, -1, -1):
        for axis in x:
            place = place << 1 | (axis >> bit & 1)
    return place
