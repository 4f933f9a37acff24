"""The rendering pipeline for NURBS surfaces: KSQuads are culled before they become triangles, anew for each view.

A KSQuad is a knot rectangle that is not empty, with the control points that it depends on. The geometry stage drops
those that face away from the eye: by all triangles of their control net (strong quad culling), by those in its middle
(light), or where it can be shown that no point of the KSQuad faces the eye (certified, ours). Strong and light culling
are no proof, and may drop what is visible. Each KSQuad has as many segments; adaptive dices are not here.

Source: Concheiro, Real Time Rendering of Parametric Surfaces on the GPU, PhD thesis, A Coruna 2013, sections 6.1, 6.2
and 6.4; Concheiro et al., Computer-Aided Design 56, 2014. Of the chapter its abstract, captions and contents were at
hand, hence the rest is a reconstruction.
"""

from __future__ import annotations

from lodbench.datasets_gen.nurbs_surface import NurbsModel
from lodbench.kernels.nurbs.rpns.host import Rpns
from lodbench.kernels.nurbs.rpns.params import Params
from lodbench.kernels.system import System

__all__ = ["Params", "Rpns", "SYSTEM"]

SYSTEM = System(
    name="rpns",
    family="nurbs",
    source="Concheiro 2013, chapter 6; Computer-Aided Design 56, 2014",
    takes=(NurbsModel,),
    prepare=Rpns,
    cases={
        "certified": Params(2),
        "strong": Params(2, culling="strong"),
        "light": Params(2, culling="light"),
        "none": Params(2, culling="none"),
    },
)
