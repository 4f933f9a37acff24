"""The method that the measurements recommend, by what is asked for, by size and by how flat the mesh is.

Edge collapse is nearest to the input and keeps a surface; above some 200 thousand triangles the hybrid has most of that
in a fraction of the time, but where much is flat, and where few triangles are to go. What only another method can do,
such as a grid of so many cells, names that. `counters` say what was taken and why.

Source: none; table `pareto` is what the rule follows.
"""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.auto.host import prepare
from lodbench.kernels.cluster.auto.params import Params
from lodbench.kernels.cluster.auto.simplify import simplify
from lodbench.kernels.system import System

__all__ = ["Params", "SYSTEM", "simplify"]


SYSTEM = System(
    name="auto",
    family="cluster",
    source="none; by table pareto",
    takes=(TriangleMesh,),
    prepare=prepare,
    cases={"tenth": Params(target_reduction=0.9)},
    verbs={"simplify": simplify},
)
