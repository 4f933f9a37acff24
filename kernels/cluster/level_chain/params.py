"""The parameters of a chain of levels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from lodbench.kernels.cluster.quadric_clustering.params import Params as Clustering
from lodbench.kernels.parameters import Range

MOST_LEVELS = 12


@dataclass(frozen=True)
class Params(Clustering):
    """How far and how to simplify; the fields of quadric clustering, its targets among them, are the first level's.

    Attributes:
        levels: how many, the first among them; each further one has half as many cells along each axis, rounded up.
    """

    levels: Annotated[int, Range(1, MOST_LEVELS)] = 4
