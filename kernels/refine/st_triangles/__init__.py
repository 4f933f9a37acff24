"""Scalar tagged triangles: curved PN triangles whose vertices say how far they bulge and where they crease.

Each vertex has three tags: tension (0 as a PN triangle, 1 straight), sharpness (0 smooth, 1 a crease along edges whose
ends are both sharp) and bias (-1 to 1, to which side a crease leans). The papers give sharpness and bias to vertices in
one place and to edges in another: a mesh's `edge_tags` come before what its vertices say. Tags change the
control points and normals of set-up alone; evaluation is that of PN triangles. Points of shared edges never depend on a
face: no tag opens a crack.

The formulas of the papers' appendix were not found: what stands here is a reconstruction (ST-R) that keeps what they
say of each tag. All tags zero give PN triangles to the bit.

Source: Boubekeur, Reuter & Schlick 2005, Scalar Tagged PN Triangles (Eurographics short paper); Boubekeur & Schlick
2005, section 4 and appendix B.
"""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.refine.refining import refiner
from lodbench.kernels.refine.st_triangles.host import StTriangles
from lodbench.kernels.refine.st_triangles.params import Params
from lodbench.kernels.system import System

__all__ = ["Params", "SYSTEM", "StTriangles", "refine"]

refine = refiner(StTriangles, Params)

SYSTEM = System(
    name="st_triangles",
    family="refine",
    source="Boubekeur, Reuter & Schlick 2005; Boubekeur & Schlick 2005, appendix B (reconstruction)",
    takes=(TriangleMesh,),
    prepare=StTriangles,
    cases={
        "smooth_16": Params(16),
        "tight_16": Params(16, tension=0.5),
        "sharp_16": Params(16, sharpness=1.0),
        "leaning_64": Params(64, tension=0.25, sharpness=0.75, bias=0.5),
    },
    verbs={"refine": refine},
)
