"""The refined mesh stored in full: what generic refinement is measured against.

Made once by the pattern's own kernel, displacement baked in; each frame reads every stored point and normal and writes
the same output. Indices are those of one pattern here too, so that both draw alike; `footprint` counts a full list.

Source: Boubekeur & Schlick, Generic Mesh Refinement on GPU, Graphics Hardware 2005, section 5, figure 7 ("Static VBO").
"""

from __future__ import annotations

from dataclasses import dataclass

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.parameters import Parameters
from lodbench.kernels.refine.lattice import Amplitude, Segments, Waves
from lodbench.kernels.refine.static_vbo.host import prepare
from lodbench.kernels.system import System


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


SYSTEM = System(
    name="static_vbo",
    family="refine",
    source="Boubekeur & Schlick 2005, section 5, figure 7",
    takes=(TriangleMesh,),
    prepare=prepare,
    cases={
        "flat_16": Params(16),
        "flat_64": Params(64),
        "flat_128": Params(128),
        "sine_64": Params(64, amplitude=0.02),
    },
)
