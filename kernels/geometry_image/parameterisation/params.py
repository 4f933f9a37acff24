"""The parameters that every system with a geometry image has for making one."""

from typing import Annotated, Literal, TypeAlias, get_args

from lodbench.kernels.parameters import Range

Level: TypeAlias = Annotated[int, Range(1, 11)]
Mode: TypeAlias = Literal["coarse_to_fine", "cmcf", "ray"]
Seed: TypeAlias = Annotated[int, Range(0)]
Turn: TypeAlias = Literal["best", "identity"]
MODES: tuple[str, ...] = get_args(Mode)
