"""A chain of levels of detail by quadric clustering: after the first, levels cost little.

The first level is quadric clustering as it is. Each further level has half as many cells along each axis, rounded up:
a cell's quadric is the sum of those of its 2 x 2 x 2 cells before, so that pass 1 is not run again, and its triangles
are decimated from those that the level before left. What is carried along is the cell of each output vertex, for a
representative may lie outside of its own cell; so each level has the triangles that clustering the mesh itself on that
grid has, its vertices are placed by the same sums, and levels are nested: each vertex has its vertex on the next one.

With `accumulate="fixed_point"` a level is that of clustering the mesh itself to the bit, where the halved grid is one
that can be asked for: any number of cubic cells, or three even counts; with private maps to the rounding of their sums.

Source: DeCoro & Tatarchuk, Real-time Mesh Simplification Using the GPU, I3D 2007, alternate pass 2.
"""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.level_chain.host import LevelChain, prepare, simplify
from lodbench.kernels.cluster.level_chain.params import Params
from lodbench.kernels.system import System

__all__ = ["SYSTEM", "LevelChain", "Params", "simplify"]

SYSTEM = System(
    name="level_chain",
    family="cluster",
    source="DeCoro & Tatarchuk 2007, alternate pass 2",
    takes=(TriangleMesh,),
    prepare=prepare,
    cases={
        "cells_64": Params(64),
        "fixed_point_64": Params(64, accumulate="fixed_point"),
        "no_duplicates_64": Params(64, remove_duplicates=True),
        "tenth": Params(target_reduction=0.9),
    },
    verbs={"simplify": simplify},
)
