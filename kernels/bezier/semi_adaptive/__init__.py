"""Semi-adaptive Bezier tessellation: tests on the edges of coarse triangles alone, whole rows of vertices between them.

Tests, those of `dabt` to the bit, decide on the edges. Inside a coarse triangle has one level, that of the edge that
bends least: a row that has a vertex on the left or the right has all vertices of that level in between, one that has
none is left out. What a triangle emits thus depends on its three edges alone: there is a pattern for each of their
combinations, at the most 26^3, made once by a kernel, in place of strips that each triangle builds anew (a
reconstruction, as is the order of its rows).

With the test "mean", not the thesis's, this and its sibling give the same: see `lodbench.kernels.bezier.grids`.

Source: Concheiro, Real Time Rendering of Parametric Surfaces on the GPU, PhD thesis, A Coruna 2013, chapter 4;
Concheiro et al., GRAPP 2014 (its successor). Of the chapter its abstract, captions and contents were at hand, hence the
rest is a reconstruction.
"""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels.bezier.gridded import by_test
from lodbench.kernels.bezier.semi_adaptive.host import SemiAdaptive
from lodbench.kernels.bezier.semi_adaptive.params import Params
from lodbench.kernels.bezier.tessellating import tessellator
from lodbench.kernels.system import System

__all__ = ["Params", "SYSTEM", "SemiAdaptive", "tessellate"]

prepare = by_test(SemiAdaptive)
tessellate = tessellator(prepare, Params)

SYSTEM = System(
    name="semi_adaptive",
    family="bezier",
    source="Concheiro 2013, chapter 4; GRAPP 2014",
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
