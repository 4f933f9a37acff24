"""The parameters of vertex shader tessellation on a handheld device."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from lodbench.kernels.bezier.level_params import LeveledParams
from lodbench.kernels.parameters import Range


@dataclass(frozen=True)
class Params(LeveledParams):
    """How finely to tessellate, how many patches at a time, and where their control points lie.

    Attributes:
        memory: of the control points: "uniform", constant memory of each draw; "texture", an image of all; or "global",
            a buffer of all.
        surfaces_per_draw: patches that one draw makes: 7 where there is room for 128 vectors, four of which a matrix
            takes, 15 where there is for 256.
    """

    memory: Literal["uniform", "texture", "global"] = "uniform"
    surfaces_per_draw: Annotated[int, Range(1, 4096)] = 7
