"""Vertex shader tessellation: one stored parametric map, evaluated over every patch in one draw.

What stays in memory is the map and the control points, whatever the level. No work-item takes another path than its
neighbours. Borders that patches share agree to the bit, and so do normals along smooth ones (reconstruction).

Source: Concheiro, Real Time Rendering of Parametric Surfaces on the GPU, PhD thesis, A Coruna 2013, chapter 2;
Concheiro et al., GRAPP 2010. Of the chapter its abstract, captions and contents were at hand, hence the rest is a
reconstruction.
"""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels.bezier.tessellating import tessellator
from lodbench.kernels.bezier.vst.host import Vst, vst
from lodbench.kernels.bezier.vst.params import Params
from lodbench.kernels.system import System

__all__ = ["Params", "SYSTEM", "Vst", "tessellate"]

tessellate = tessellator(vst, Params)

SYSTEM = System(
    name="vst",
    family="bezier",
    source="Concheiro 2013, chapter 2; GRAPP 2010",
    takes=(BezierPatches,),
    prepare=vst,
    cases={
        "level_4": Params(4),
        "level_2": Params(2),
        "level_5": Params(5),
        "level_7": Params(7),
        "positions_7": Params(7, normals=False),
        "screen_5": Params(5, by="screen"),
    },
    verbs={"tessellate": tessellate},
)
