"""Uniform tessellation of NURBS surfaces: as many segments on every surface, or on every KSQuad of all.

Basis functions are evaluated once for each row and column of a grid, by the stair strategy, and each row is a curve
whose control points are summed once for each span: no conversion to Bezier patches, and surfaces may differ in degree.
Borders that surfaces share agree to the bit (reconstruction).

Source: Concheiro, Real Time Rendering of Parametric Surfaces on the GPU, PhD thesis, A Coruna 2013, sections 6.2, 6.5
and figure 6.4a; Concheiro et al., Computer-Aided Design 56, 2014. Of the chapter its abstract, captions and contents
were at hand, hence the rest is a reconstruction.
"""

from __future__ import annotations

from lodbench.datasets_gen.nurbs_surface import NurbsModel
from lodbench.kernels.nurbs.tessellating import tessellator
from lodbench.kernels.nurbs.uniform_nurbs.host import UniformNurbs
from lodbench.kernels.nurbs.uniform_nurbs.params import Params
from lodbench.kernels.system import System

__all__ = ["Params", "SYSTEM", "UniformNurbs", "tessellate"]

tessellate = tessellator(UniformNurbs, Params)

SYSTEM = System(
    name="uniform_nurbs",
    family="nurbs",
    source="Concheiro 2013, chapter 6, figure 6.4a; Computer-Aided Design 56, 2014",
    takes=(NurbsModel,),
    prepare=UniformNurbs,
    cases={
        "level_4": Params(4),
        "quads_3": Params(3, "span"),
        "triangle": Params(5, basis="triangle"),
        "cox_de_boor": Params(5, basis="cox_de_boor"),
        "positions_7": Params(7, normals=False),
        "near": Params(tolerance=1e-3),
    },
    verbs={"tessellate": tessellate},
)
