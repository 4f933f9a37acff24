"""The parameters of a refined mesh that is stored."""

from __future__ import annotations

from dataclasses import dataclass

from lodbench.kernels.parameters import Parameters
from lodbench.kernels.refine.lattice import Amplitude, Segments, Waves


@dataclass(frozen=True)
class Params(Parameters):
    """What is stored.

    Attributes:
        segments: parts that each coarse edge is cut into, 1 to 4096.
        amplitude: of the displacement a sin(f |P|), as a fraction of the bounding-box diagonal; 0 for none.
            It stands still.
        waves: of that sine per bounding-box diagonal.
    """

    segments: Segments = 16
    amplitude: Amplitude = 0.0
    waves: Waves = 8.0
