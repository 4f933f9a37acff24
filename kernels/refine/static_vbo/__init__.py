"""The refined mesh stored in full: what generic refinement is measured against.

Made once by the pattern's own kernel, displacement baked in; each frame reads every stored point and normal and writes
the same output. Indices are those of one pattern here too, so that both draw alike; `footprint` counts a full list.

Source: Boubekeur & Schlick, Generic Mesh Refinement on GPU, Graphics Hardware 2005, section 5, figure 7 ("Static VBO").
"""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.refine.static_vbo.host import StaticVbo
from lodbench.kernels.refine.static_vbo.params import Params
from lodbench.kernels.system import System

__all__ = ["SYSTEM", "Params"]

SYSTEM = System(
    name="static_vbo",
    family="refine",
    source="Boubekeur & Schlick 2005, section 5, figure 7",
    takes=(TriangleMesh,),
    prepare=StaticVbo,
    cases={
        "flat_16": Params(16),
        "flat_64": Params(64),
        "flat_128": Params(128),
        "sine_64": Params(64, amplitude=0.02),
    },
)
