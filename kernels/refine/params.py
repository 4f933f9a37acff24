"""The parameters that every refinement by patterns has."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from lodbench.kernels.parameters import Parameters, Range
from lodbench.kernels.refine.lattice import Amplitude, Segments, Waves


@dataclass(frozen=True)
class RefineParams(Parameters):
    """How to refine.

    Attributes:
        segments: parts that each coarse edge is cut into, 1 to 4096.
        levels: nested patterns held ready, the coarser with half the segments of the finer; `segments` must allow
            for it. `Frame.view` chooses: each doubling of the eye's distance past `near` halves the segments.
        displacement: what raises the surface along its normals: "sine", a sin(f |P|); "perlin", octaves of noise; or
            "turbulence", their absolute values.
        amplitude: its height, as a fraction of the bounding-box diagonal; 0 for none.
        waves: of the sine, or cells of the coarsest noise, per bounding-box diagonal; one passes per second of
            `Frame.time`.
        octaves: of the noise, each twice as fine and half as high as the one before.
        near: distance of the eye from the box, in diagonals, up to which the finest level is shown.
    """

    segments: Segments = 16
    levels: Annotated[int, Range(1, 13)] = 1
    displacement: Literal["sine", "perlin", "turbulence"] = "sine"
    amplitude: Amplitude = 0.0
    waves: Waves = 8.0
    octaves: Annotated[int, Range(1, 12)] = 4
    near: Annotated[float, Range(0, open="low")] = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.segments % (1 << (self.levels - 1)):
            raise ValueError(
                f"levels: expected halvings of {self.segments} segments, got {self.levels}"
            )
