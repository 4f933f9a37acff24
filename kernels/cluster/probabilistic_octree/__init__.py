"""The octree as published: all its levels in one hash table that may lose nodes, and knows which.

A node's key is its level and place. Every corner adds its triangle's quadric to the slots of the nodes above it, and
the slot keeps the largest and the smallest key that was written to it: where they differ two nodes have met, and
neither can be read. A vertex then goes to the coarsest node on its way to the root that can be read and whose error
keeps to the threshold; where a node was lost its parent answers, which is coarser and never wrong. The root has a slot
of its own. Read keys are compared with the one asked for too, since a slot may belong to another node alone.

The slides leave the hash and the randomised construction open: both are reconstructions, as is the centre of the box as
the representative of a root to which nothing was written.

Source: DeCoro & Tatarchuk, Real-time Mesh Simplification Using the GPU, I3D 2007, slides 29-33.
"""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.prepare import simplifier
from lodbench.kernels.cluster.probabilistic_octree.host import ProbabilisticOctree, prepare
from lodbench.kernels.cluster.probabilistic_octree.params import Params
from lodbench.kernels.system import System

__all__ = ["Params", "ProbabilisticOctree", "SYSTEM", "simplify"]

simplify = simplifier(prepare, Params)

SYSTEM = System(
    name="probabilistic_octree",
    family="cluster",
    source="DeCoro & Tatarchuk 2007, slides 29-33",
    takes=(TriangleMesh,),
    prepare=prepare,
    cases={
        "level_5": Params(max_error=0.01, levels=5),
        "crowded": Params(max_error=0.003, levels=4, storage=0.03, search="binary"),
        "randomised": Params(max_error=0.003, levels=5, construction="randomised"),
        "half": Params(target_reduction=0.5, levels=5, storage=0.3, rule="total"),
    },
    verbs={"simplify": simplify},
)
