"""Vertex clustering with means: one vertex per grid cell, where the cell's vertices lie on average.

What quadrics are measured against: the same cells and the same triangles, only corners and creases are rounded off.

Source: Rossignac & Borrel 1993, Multi-resolution 3D approximations for rendering complex scenes, all weights equal;
DeCoro & Tatarchuk 2007, slide 14, compare with it.
"""

from __future__ import annotations

from typing import Any

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.prepare import simplifier
from lodbench.kernels.cluster.vertex_average.host import prepare
from lodbench.kernels.cluster.vertex_average.params import Params
from lodbench.kernels.result import Left
from lodbench.kernels.system import System

__all__ = ["SYSTEM", "Params"]


def streams(*arguments: Any, **options: Any) -> Left:
    """See `cluster/streaming.py`."""
    from lodbench.kernels.cluster.streaming import streamer  # trimesh
    from lodbench.kernels.cluster.vertex_average.batches import Batches

    return streamer(Batches, Params)(*arguments, **options)


SYSTEM = System(
    name="vertex_average",
    family="cluster",
    source="Rossignac & Borrel 1993; DeCoro & Tatarchuk 2007, slide 14",
    takes=(TriangleMesh,),
    prepare=prepare,
    cases={"cells_64": Params(64), "tenth": Params(target_reduction=0.9)},
    verbs={"simplify": simplifier(prepare, Params)},
    streams=streams,
)
