"""The parameters of tessellations whose patches may have a level each."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Literal

import numpy as np

from lodbench.kernels.bezier.params import BezierParams
from lodbench.kernels.parameters import Range

FINEST = 10


@dataclass(frozen=True)
class LeveledParams(BezierParams):
    """How finely to tessellate, all patches alike or each by itself.

    Attributes:
        by: "level", every patch has `level`; or "screen", a patch has as fine a level, up to that, as the longest of
            its borders needs for segments of at most `pixels` in a frame's view.
        pixels: length of a segment on the screen.
        levels: of each patch, in place of `level`: any sequence of whole numbers, 0 to 10. Of two neighbours the
            coarser decides about the border between them.
    """

    by: Literal["level", "screen"] = field(default="level", kw_only=True)
    pixels: Annotated[float, Range(0, open="low")] = field(default=8.0, kw_only=True)
    levels: tuple | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if self.levels is not None:
            found = np.asarray(self.levels)
            if found.ndim != 1 or found.dtype.kind not in "iu":
                raise TypeError(
                    f"levels: expected (n,) whole numbers, got {found.dtype} {found.shape}"
                )
            if len(found) and not 0 <= found.min() <= found.max() <= FINEST:
                raise ValueError(
                    f"levels: expected 0 to {FINEST}, got {found.min()} to {found.max()}"
                )
            object.__setattr__(self, "levels", tuple(found.tolist()))
        super().__post_init__()
        if self.levels is not None and self.by != "level":
            raise ValueError("levels: expected by='level' beside them, got by='screen'")

    @property
    def is_uniform(self) -> bool:
        """Have all patches the same level?"""
        return self.by == "level" and self.levels is None

    @property
    def finest(self) -> int:
        """The finest level that a patch may have."""
        return max(self.levels, default=0) if self.levels is not None else self.level
