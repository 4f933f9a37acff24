"""Quadric vertex clustering: one vertex per grid cell, where the planes of the cell's triangles meet best.

Each triangle adds a third of its area times the squared distance to its plane to the cells of its corners; each cell's
representative minimises its sum; a triangle survives when its corners lie in three cells. Output triangles keep the
input's order; output vertices are the cells that a surviving triangle uses, in ascending cell order, so that no vertex
comes out unused and none that no triangle refers to pulls on anything (it does stretch the box).

Where the paper accumulates in render targets over the whole grid, the cluster map here holds occupied cells alone, and
pass 3 rides along with pass 1. The paper solves where det(A) > 1e-11; that holds in few cells of most meshes and gives
the plain average in the others, so the default regularises the solve instead (reconstruction). Nor does it say
anything of borders, which shrink without help: border edges add planes of their own (reconstruction), or their
vertices stay as they are.

Source: DeCoro & Tatarchuk, Real-time Mesh Simplification Using the GPU, I3D 2007, slides 10-17; Lindstrom 2000,
Out-of-Core Simplification of Large Polygonal Models.
"""

from __future__ import annotations

from typing import Any

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.prepare import simplifier
from lodbench.kernels.cluster.quadric_clustering.host import QuadricClustering, prepare
from lodbench.kernels.cluster.quadric_clustering.params import Params
from lodbench.kernels.result import Left
from lodbench.kernels.stages.camera import look_at
from lodbench.kernels.system import System

__all__ = ["Params", "SYSTEM", "QuadricClustering", "simplify"]

simplify = simplifier(prepare, Params)
CUBE = "float warp(const float t, const int axis) { return t * (0.2f + t * t); }"


def streams(*arguments: Any, **options: Any) -> Left:
    """See `cluster/streaming.py`."""
    from lodbench.kernels.cluster.quadric_clustering.batches import Batches  # trimesh
    from lodbench.kernels.cluster.streaming import streamer

    return streamer(Batches, Params)(*arguments, **options)


SYSTEM = System(
    name="quadric_clustering",
    family="cluster",
    source="DeCoro & Tatarchuk 2007, slides 10-17",
    takes=(TriangleMesh,),
    prepare=prepare,
    cases={
        "cells_64": Params(64),
        "cells_30": Params(30),
        "cells_124": Params(124),
        "average_64": Params(64, placement="average"),
        "paper_64": Params(64, placement="paper"),
        "separate_64": Params(64, strategy="separate"),
        "slabs_64": Params(64, accumulate="slabs", slabs=4),
        "fixed_point_64": Params(64, accumulate="fixed_point"),
        "no_duplicates_64": Params(64, remove_duplicates=True),
        "border_none_30": Params(30, border="none"),
        "border_kept_30": Params(30, border="keep"),
        "tenth": Params(target_reduction=0.9),
        "region_64": Params(64, regions=((1.0, 0.0, 0.0, 0.3, 8.0),)),
        "view_64": Params(64, view=look_at((2, 1, 2), (0, 0, 0))),  # pyright: ignore[reportArgumentType]
        "warp_64": Params(64, warp=CUBE),
    },
    verbs={"simplify": simplify},
    streams=streams,
)
