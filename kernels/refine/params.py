"""The parameters that every refinement by patterns has."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from lodbench.kernels.parameters import Parameters, Range
from lodbench.kernels.refine.lattice import Amplitude, Segments, Waves


@dataclass(frozen=True)
class RefineParams(Parameters):
    """How to refine.

    Attributes:
        segments: parts that each coarse edge is cut into, 1 to 4096.
        levels: nested patterns held ready, the coarser with half the segments of the finer; `segments` must allow
            for it. `Frame.view` chooses: each doubling of the eye's distance past `near` halves the segments.
        amplitude: of the displacement a sin(f |P|), as a fraction of the bounding-box diagonal; 0 for none.
        waves: of that sine per bounding-box diagonal; one passes per second of `Frame.time`.
        near: distance of the eye from the box, in diagonals, up to which the finest level is shown.
    """

    segments: Segments = 16
    levels: Annotated[int, Range(1, 13)] = 1
    amplitude: Amplitude = 0.0
    waves: Waves = 8.0
    near: Annotated[float, Range(0, open="low")] = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.segments % (1 << (self.levels - 1)):
            raise ValueError(
                f"levels: expected halvings of {self.segments} segments, got {self.levels}"
            )
