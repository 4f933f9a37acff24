"""Vertex shader tessellation on a handheld device: a few patches to a draw, control points in uniforms or a texture.

Without instancing a draw of N_d patches needs the map N_d times, with the patch's number beside each vertex, and room
for 16 vectors of each patch in constant memory; a texture holds all patches. The vertices are those of `vst` to the
bit, wherever the control points lie.

Source: Concheiro, Real Time Rendering of Parametric Surfaces on the GPU, PhD thesis, A Coruna 2013, chapter 5;
Concheiro et al., WSCG 2013. That both kinds of memory are compared is stated there; how a draw is laid out is a
reconstruction.
"""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels.bezier.tessellating import tessellator
from lodbench.kernels.bezier.vsthd.host import Vsthd, vsthd
from lodbench.kernels.bezier.vsthd.params import Params
from lodbench.kernels.system import System

__all__ = ["Params", "SYSTEM", "Vsthd", "tessellate"]

tessellate = tessellator(vsthd, Params)

SYSTEM = System(
    name="vsthd",
    family="bezier",
    source="Concheiro 2013, chapter 5; WSCG 2013",
    takes=(BezierPatches,),
    prepare=vsthd,
    cases={
        "uniform_3": Params(3),
        "texture_3": Params(3, memory="texture"),
        "global_3": Params(3, memory="global"),
        "uniform_15": Params(3, surfaces_per_draw=15),
        "screen_4": Params(4, by="screen"),
        "texture_screen_3": Params(3, by="screen", memory="texture"),
        "global_screen_3": Params(3, by="screen", memory="global"),
        "positions_3": Params(3, normals=False),
    },
    verbs={"tessellate": tessellate},
)
