"""What the sweeps of a frame are to do, and the sizes of what they work in."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from lodbench.kernels.cluster.edge_collapse.bound import Limit
from lodbench.kernels.cluster.edge_collapse.params import Params

ASKED = 4  # blocks whose costs are enough to tell what edges may cost
ASKED_LAST, APART = (
    8,
    4,
)  # in the last sweeps also which of them takes how much: one of so many that lie together
ROOM = 1.5  # the grid's edge, times the mesh's: by what is left it is shifted between sweeps
SHIFTS = (0.8191725134, 0.6710436067, 0.5497004779)  # multiples whose fractions keep their distance
MOST_BITS = 6  # of cells along an axis
LAST_GAIN = 0.7  # of what the first sweeps take
WHOLE = 1024  # triangles that are one block in the last sweeps, however small blocks are
PATIENCE = 4  # last sweeps after which blocks grow
MORE = 14  # last sweeps at most
STUBBORN = 8  # last sweeps after which a target that is still missed counts more than how far triangles turn
CAPACITY = 4096  # triangles that a work-item has room for


@dataclass(frozen=True)
class Sweep:
    """One of them.

    Attributes:
        number: from 1.
        goal: triangles that it is to leave, about.
        bits: of the cells along an axis of the grid that triangles are sorted by.
        gain: share of the edges that may be collapsed, for a share of the triangles that is to go.
        last: blocks have quotas by their costs, so that the target is met.
        block: most triangles of a block; growing in the end, for meshes that no smaller one holds a vertex of.
        whole: triangles that are one block.
        least: share of the edges that may be collapsed at the least, more and more in the last sweeps, so that they
            come to an end; 0 before.
        stubborn: triangles may turn by up to 90 degrees.
    """

    number: int
    goal: int
    bits: int
    gain: float
    last: bool
    block: int
    whole: int
    least: float
    stubborn: bool

    @property
    def along(self) -> float:
        """Cells along the mesh's longest extent."""
        return (1 << self.bits) / ROOM

    @property
    def shift(self) -> tuple[float, ...]:
        """Of the grid along each axis, in cells."""
        most = (1 << self.bits) - self.along
        return tuple(math.modf(self.number * step)[0] * most for step in SHIFTS)


def sweeps(
    params: Params, triangle_count: int, target: int, limit: Limit | None = None
) -> Iterator[Sweep]:
    """In equal steps to the target, and more for what may be left; those after the target is met do nothing.

    With a limit the steps go to what it is thought to leave, and triangles turn no further in the end.
    """
    aim = target if limit is None else max(limit.guess, target)
    share, before = aim / max(triangle_count, 1), triangle_count
    for number in range(1, params.sweeps + MORE + 1):
        extra = number - params.sweeps
        goal = round(triangle_count * share ** min(number / params.sweeps, 1))
        least = least_share(extra) if extra > 0 else 0.0
        gain = params.gain * (LAST_GAIN if extra >= 0 else 1)
        block = min(params.block << max(extra - PATIENCE, 0), CAPACITY)
        whole = max(block, WHOLE) if extra >= 0 else block
        bits = bits_of(before, params.block)
        yield Sweep(
            number, max(goal, target), bits, gain, extra > 0, block, whole, least,
            extra > STUBBORN and limit is None,
        )  # fmt: skip
        before = max(goal, target)


def least_share(extra: int) -> float:
    """Of the edges that the last sweeps may collapse, by how many there were before."""
    return min(0.002 * 1.7**extra, 1.0)


def bits_of(triangle_count: int, block: int) -> int:
    """Of the cells along an axis: a block has several of those that a surface goes through, so that rims are even and
    move between sweeps; no more than a core's cache has counters for, where a block has one at least.
    """
    blocks = max(triangle_count / block, 1)
    wanted, least = (math.ceil(math.log(share * blocks, 4)) for share in (8, 1))
    return max(4 if blocks > 1 else 1, min(wanted, 5), min(least, MOST_BITS))


def slice_words() -> int:
    """Words of a work-item's slice of memory, as `block.cl` has it."""
    vertices, edges = 3 * CAPACITY, 4 * CAPACITY
    words = 16 * vertices + 8 * edges + 48 + vertices + 6 * CAPACITY + 3 * vertices + edges // 2
    return (words + 31) // 16 * 16
