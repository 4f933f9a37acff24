"""Geometry shader tessellation: each patch is one primitive, sampled in zones whose output a geometry shader may hold.

There is no stored map: virtual vertices are made on the fly, and come out as triangle strips, inner rows twice. A zone
emits at most 1024 numbers. What a zone evaluates beforehand, the surface by powers, all of its samples use; along a row
they use that row's curve (both, one or none: `reuse`). Borders are evaluated from their own control points and agree to
the bit, also with those of `vst`.

Source: Concheiro, Real Time Rendering of Parametric Surfaces on the GPU, PhD thesis, A Coruna 2013, chapter 2;
Concheiro et al., GRAPP 2010. The limit, the zones and that reuse ends with them are stated there; their shape is a
reconstruction.
"""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels.bezier.gst.host import Gst, gst
from lodbench.kernels.bezier.gst.params import Params
from lodbench.kernels.bezier.tessellating import tessellator
from lodbench.kernels.system import System

__all__ = ["Gst", "Params", "SYSTEM", "tessellate"]

tessellate = tessellator(gst, Params)

SYSTEM = System(
    name="gst",
    family="bezier",
    source="Concheiro 2013, chapter 2; GRAPP 2010",
    takes=(BezierPatches,),
    prepare=gst,
    cases={
        "level_4": Params(4),
        "level_2": Params(2),
        "level_5": Params(5),
        "zone_5": Params(5, reuse="zone"),
        "none_5": Params(5, reuse="none"),
        "positions_5": Params(5, normals=False),
        "positions_zone_5": Params(5, normals=False, reuse="zone"),
        "screen_5": Params(5, by="screen"),
        "positions_none_5": Params(5, normals=False, reuse="none"),
    },
    verbs={"tessellate": tessellate},
)
