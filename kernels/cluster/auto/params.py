"""The parameters of the choice."""

from __future__ import annotations

from dataclasses import dataclass

from lodbench.kernels.targets import Target


@dataclass(frozen=True)
class Params(Target):
    """How far to simplify; targets are those of `Target`, at most one of them; a tenth is left where none is given."""
