"""Curved PN triangles: a cubic patch of each coarse triangle from its corners and normals alone, under patterns.

Ten control points and six control normals per triangle are made once, on the device; no adjacency is needed. Neighbours
share the curve of their edge to the bit where they share its normals; where normals are split, a crease opens.

Source: Vlachos, Peters, Boyd & Mitchell 2001, Curved PN Triangles, sections 3.1 and 3.3; the appendix of Boubekeur &
Schlick 2005 that has it under patterns. The evaluation in powers of u and v about the lowest corner is ours.
"""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.refine.pattern import DIMPLES
from lodbench.kernels.refine.pn_triangles.host import PnTriangles
from lodbench.kernels.refine.pn_triangles.params import Params
from lodbench.kernels.refine.refining import refiner
from lodbench.kernels.system import System

__all__ = ["Params", "PnTriangles", "SYSTEM", "refine"]

refine = refiner(PnTriangles, Params)

SYSTEM = System(
    name="pn_triangles",
    family="refine",
    source="Vlachos et al. 2001, sections 3.1 and 3.3; Boubekeur & Schlick 2005, appendix A",
    takes=(TriangleMesh,),
    prepare=PnTriangles,
    cases={
        "quadratic_16": Params(16),
        "linear_16": Params(16, shading_normals="linear"),
        "quadratic_64": Params(64),
        "sine_64": Params(64, amplitude=0.02),
        "function_64": Params(64, displacement="function", function=DIMPLES),
        "levels_64": Params(64, levels=7),
    },
    verbs={"refine": refine},
)
