"""The rendering pipeline for NURBS surfaces: KSQuads are culled before they become triangles, anew for each view.

A KSQuad is a knot rectangle that is not empty, with the control points that it depends on. The geometry stage drops
those that face away from the eye: by all triangles of their control net (strong quad culling), by those in its middle
(light), or where it can be shown that no point of the KSQuad faces the eye (certified, ours). Strong and light culling
are no proof, and may drop what is visible. The sampler cuts those that stay into KSDices, cells of a grid that cover so
many pixels each, and may drop those that face away. KSQuads meet without cracks: each border is cut by its own length
on the screen, and both that have it move their vertices there to the same places, to the bit.

Source: Concheiro, Real Time Rendering of Parametric Surfaces on the GPU, PhD thesis, A Coruna 2013, sections 6.1 to
6.5; Concheiro et al., Computer-Aided Design 56, 2014. Of the chapter its abstract, captions and contents were at hand,
hence the rest is a reconstruction.
"""

from __future__ import annotations

from typing import Any

from lodbench.datasets_gen.nurbs_surface import NurbsModel
from lodbench.kernels.nurbs.rpns.host import Rpns
from lodbench.kernels.nurbs.rpns.params import Params
from lodbench.kernels.nurbs.tessellating import tessellator
from lodbench.kernels.system import System

__all__ = ["Params", "Rpns", "SYSTEM", "tessellate"]


def _chosen(options: dict[str, Any]) -> dict[str, Any]:
    """For a file all sides are wanted, and what is given by pixels adapts to them."""
    return {"culling": "none", "sampling": "adaptive", "level": 6} | options


tessellate = tessellator(Rpns, Params, _chosen)

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
        "adaptive": Params(6, sampling="adaptive", dice_culling=True),
        "non_uniform": Params(6, sampling="non_uniform"),
        "tolerant": Params(6, sampling="adaptive", edges="tolerant"),
        "one": Params(sampling="one"),
    },
    verbs={"tessellate": tessellate},
)
