"""The parameters of the published, hashed octree."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from lodbench.kernels.cluster.octree.params import DEFAULT_ERROR, DEFAULT_LEVELS
from lodbench.kernels.cluster.target import ClusterTarget
from lodbench.kernels.parameters import Range

MAX_LEVELS = 8
ROOT_SLOTS = 2  # the root's own, and one more: the smallest table


@dataclass(frozen=True)
class Params(ClusterTarget):
    """How far to simplify; targets are those of `Target`, at most one of them and `max_error`, which is else 1e-3.

    Attributes:
        max_error: largest error of a node, share of the bounding-box diagonal, by `rule`.
        levels: of the finest grid, 2^levels cells along the longest box edge; None: by the target, from 6 up, else 7.
        storage: slots of the table as a share of all cells of all levels; above 1 it is larger than the tree.
        construction: "full", every corner writes to all levels; "randomised", to the finest, and to each coarser one
            with half the probability of the one before, with the inverse as its weight.
        search: of a vertex's level: "linear", scanning from the root; "binary", as if errors fell from level to level.
        rule: what a node's error is: "rms", the root of its quadric error over its area, as published; "total", the
            root of that error over the mesh's whole area.
        seed: of the hash, and of what is written.
    """

    max_error: Annotated[float, Range(0)] | None = None
    levels: Annotated[int, Range(1, MAX_LEVELS)] | None = None
    storage: Annotated[float, Range(0, 1000, open="low")] = 0.08
    construction: Literal["full", "randomised"] = "full"
    search: Literal["linear", "binary"] = "linear"
    rule: Literal["rms", "total"] = "rms"
    seed: Annotated[int, Range(0, 2**31 - 1)] = 0

    @property
    def error(self) -> float:
        """The largest error where no number of triangles is asked for, share of the diagonal."""
        return DEFAULT_ERROR if self.max_error is None else self.max_error

    @property
    def grid_cells(self) -> int:
        """Of the finest grid along the longest box edge."""
        return 1 << (self.levels or DEFAULT_LEVELS)

    @property
    def full_tree(self) -> int:
        """Cells of all levels, occupied or not."""
        finest = self.grid_cells.bit_length() - 1
        return (8 ** (finest + 1) - 1) // 7

    @property
    def slots(self) -> int:
        """Of the table."""
        return max(round(self.storage * self.full_tree), ROOT_SLOTS)
