"""Dynamic and adaptive Bezier tessellation: coarse triangles that insert vertices where local tests ask for them.

A patch begins as coarse triangles between points of its own. Each has a fixed pattern of places for vertices; a test of
each place, by distance from the chord, angle or length on the screen, decides, on an edge from that edge's own data
alone, so that neighbours agree to the bit. An edge's finest level says which places are tested in the third of the
triangle next to it. The vertices inserted are strips, which are zipped; all of it is done by one geometry stage that
tests and counts, a scan, and one that emits.

With the test "mean", not the thesis's, this and its sibling give the same: see `lodbench.kernels.bezier.grids`.

Source: Concheiro, Real Time Rendering of Parametric Surfaces on the GPU, PhD thesis, A Coruna 2013, chapter 3;
Concheiro et al., GRAPP 2011. Of the chapter its abstract, captions and contents were at hand, hence the rest is a
reconstruction.
"""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels.bezier.dabt.host import Dabt
from lodbench.kernels.bezier.dabt.params import Params
from lodbench.kernels.bezier.gridded import by_test
from lodbench.kernels.bezier.tessellating import tessellator
from lodbench.kernels.system import System

__all__ = ["Dabt", "Params", "SYSTEM", "tessellate"]

prepare = by_test(Dabt)
tessellate = tessellator(prepare, Params)

SYSTEM = System(
    name="dabt",
    family="bezier",
    source="Concheiro 2013, chapter 3; GRAPP 2011",
    takes=(BezierPatches,),
    prepare=prepare,
    cases={
        "distance_5": Params(5),
        "flat_4": Params(4, test="flat"),
        "length_4": Params(4, test="length"),
        "mean_5": Params(5, test="mean"),
        "all_3": Params(3, threshold=0.0),
        "shallow_2": Params(2, normals=False),
    },
    verbs={"tessellate": tessellate},
)
