"""The parameters of a chain of levels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from lodbench.kernels.cluster.quadric_clustering.params import Params as Clustering
from lodbench.kernels.cluster.warped import WARPS
from lodbench.kernels.parameters import Range

MOST_LEVELS = 12


@dataclass(frozen=True)
class Params(Clustering):
    """How far and how to simplify; the fields of quadric clustering, its targets among them, are the first level's.

    Attributes:
        levels: how many, the first among them; each further one has half as many cells along each axis, rounded up.
    """

    levels: Annotated[int, Range(1, MOST_LEVELS)] = 4

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in WARPS:
            if getattr(self, name):
                raise ValueError(f"{name}: expected none for a chain of levels, got one")
        if self.keeps_border:
            raise ValueError("border: expected quadrics or none for a chain of levels, got keep")
