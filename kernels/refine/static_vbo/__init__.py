"""The refined mesh stored in full: what generic refinement is measured against.

Any of the family's surfaces, made once by its own kernel, displacement baked in; each frame reads every stored point
and normal and writes the same output. Indices are those of one pattern here too, so that both draw alike; `footprint`
counts a full list.

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
        "perlin_16": Params(16, displacement="perlin", amplitude=0.02),
        "pn_triangles_16": Params(16, surface="pn_triangles"),
        "st_triangles_16": Params(
            16, surface="st_triangles", tension=0.3, sharpness=0.6, bias=-0.5
        ),
    },
)
