"""The parameters of scalar tagged triangles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from lodbench.kernels.parameters import Range
from lodbench.kernels.refine.params import RefineParams


@dataclass(frozen=True)
class Params(RefineParams):
    """How to refine, and the tags of a mesh that brings none of its own.

    A mesh's own `tags`, (n, 3) tension, sharpness and bias of each vertex, come before these.

    Attributes:
        tension: of every vertex: 0 bulges as a PN triangle, 1 is straight, below 0 bulges more.
        sharpness: of every vertex; an edge creases by the product of its ends'.
        bias: of every vertex: to which side a crease leans; an edge has the mean of its ends'.
    """

    tension: Annotated[float, Range(-1, 1)] = 0.0
    sharpness: Annotated[float, Range(0, 1)] = 0.0
    bias: Annotated[float, Range(-1, 1)] = 0.0
