"""What the sweeps of a frame are to do, and the sizes of what they work in."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from lodbench.kernels.cluster.edge_collapse.params import Params

ASKED = 16  # blocks whose costs are enough to tell what edges may cost
ROOM = 1.5  # the grid's edge, times the mesh's: by what is left it is shifted between sweeps
SHIFTS = (0.8191725134, 0.6710436067, 0.5497004779)  # multiples whose fractions keep their distance
MOST_BITS = 6  # of cells along an axis
LAST_GAIN = 0.7  # of what the first sweeps take
WHOLE = 1024  # triangles that are one block in the last sweeps, however small blocks are


@dataclass(frozen=True)
class Sweep:
    """One of them.

    Attributes:
        number: from 1.
        goal: triangles that it is to leave, about.
        bits: of the cells along an axis of the grid that triangles are sorted by.
        gain: share of the edges that may be collapsed, for a share of the triangles that is to go.
        last: blocks have quotas by their costs, so that the target is met.
        least: share of the edges that may be collapsed at the least, more and more in the last sweeps, so that they
            come to an end; 0 before.
    """

    number: int
    goal: int
    bits: int
    gain: float
    last: bool
    least: float

    @property
    def along(self) -> float:
        """Cells along the mesh's longest extent."""
        return (1 << self.bits) / ROOM

    @property
    def shift(self) -> tuple[float, ...]:
        """Of the grid along each axis, in cells."""
        most = (1 << self.bits) - self.along
        return tuple(math.modf(self.number * step)[0] * most for step in SHIFTS)


def sweeps(params: Params, triangle_count: int, target: int) -> Iterator[Sweep]:
    """In equal steps to the target, and more for what may be left; those after the target is met do nothing."""
    share, before = target / max(triangle_count, 1), triangle_count
    for number in range(1, params.sweeps + 15):
        extra = number - params.sweeps
        goal = round(triangle_count * share ** min(number / params.sweeps, 1))
        least = least_share(extra) if extra >= 0 else 0.0
        gain = params.gain * (LAST_GAIN if extra >= 0 else 1)
        yield Sweep(number, max(goal, target), bits_of(before, params.block), gain, extra >= 0, least)
        before = max(goal, target)


def least_share(extra: int) -> float:
    """Of the edges that the last sweeps may collapse, by how many there were before."""
    return min(0.004 * 1.6**extra, 1.0)


def bits_of(triangle_count: int, block: int) -> int:
    """Of the cells along an axis, so that a block has some of those that a surface goes through."""
    return max(3, min(MOST_BITS, math.ceil(math.log(max(1.1 * triangle_count / block, 1), 4))))


def capacity(block: int) -> int:
    """Triangles that a work-item has room for; in the last sweeps the whole mesh is one block where it has no more."""
    return max(block, WHOLE)


def slice_words(block: int) -> tuple[int, int]:
    """Words of a work-item's slice, and slots of its hash table, as `block.cl` has them."""
    block = capacity(block)
    vertices, edges = 3 * block, 4 * block
    slots = 1 << (4 * block - 1).bit_length()
    words = 16 * vertices + 4 * edges + vertices + 4 * block + 3 * vertices + slots // 2
    return (words + 31) // 16 * 16, slots
