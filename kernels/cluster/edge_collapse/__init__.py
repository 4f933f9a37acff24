"""Edge collapse: the cheapest edges go, in many places at once.

Garland & Heckbert's edge collapse takes one edge after the other, the cheapest of all first. It has two forms here, of
one quality. In **blocks**, the form for CPUs, triangles are sorted along a curve through the cells of a grid and cut
into blocks of some 1,500; a work-item takes a block and collapses the edges whose two ends have no triangle in another
block, cheapest first by a queue of its own, as long as they cost no more than a threshold that all blocks share: a
quantile of costs of some blocks. The grid is shifted between sweeps, so that what was on a block's rim lies within one
in the next. In the last sweeps each block has a quota, by the number of cheap edges in one of the blocks next to it, so
that the target is met. No two blocks change the same vertex: any number of cores gives the same.

Quadrics are made anew from the mesh as it is in every sweep and added up within one. They are kept about their own
vertices, where b and c begin as zero, so that float32 is enough; half of the volume is made up for that a collapse
would take away. An edge goes only where the surface stays what it was (the link condition, with the border as one more
vertex; where it is no surface, edges of many triangles go too) and no triangle turns by more than a limit. Planes
upright on border edges and on folds hold these. A closed part of the mesh ends as four triangles at the least, so that
none is lost.

With `max_error` the input and the output are compared both ways, and collapses limited where these are too far apart
(`bound.py`).

In **rounds**, the form for GPUs, every edge has its cost in every round. One goes where no edge at its ends or at their
neighbours costs less, and where it costs no more than a quantile of all: then no triangle touches two that go, so that
the order does not matter. What a vertex has is its ring: for each of its triangles the next and the previous corner.
Winners join two rings, and between rounds vertices and rings are copied to the front of a second set of buffers. An
edge whose rings did not change keeps its cost, or that it may not go; where they changed, one that was far above the
quantile is not asked again yet. The last round takes the cheapest of its winners.

`collapses` gives the collapses in a valid order, and `replay` any level of detail out of these.

Source: Garland & Heckbert, Surface Simplification Using Quadric Error Metrics, SIGGRAPH 97 (section 6 for border
planes); quadrics of the current mesh and volume after Lindstrom & Turk, Fast and Memory Efficient Polygonal
Simplification, 1998; link condition of Dey, Edelsbrunner, Guha & Nekhayev 1999. Blocks, the shared threshold, shifts
and quotas are of our own design, and so are the rounds; the constants of blocks were chosen on bunny_closed_70k,
armadillo_86k, rocker_arm, mountain_od and a sphere, those of rounds on fandisk, armadillo_86k, dragon_100k,
mountain_od, mechpart_g3, rocker_arm, kitten_g1 and cheburashka.
"""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.edge_collapse.host import EdgeCollapse
from lodbench.kernels.cluster.edge_collapse.params import Params
from lodbench.kernels.cluster.edge_collapse.prepare import prepare
from lodbench.kernels.cluster.edge_collapse.replay import Collapses, collapses, replay
from lodbench.kernels.cluster.edge_collapse.simplify import simplify
from lodbench.kernels.system import System

__all__ = ["Collapses", "EdgeCollapse", "Params", "SYSTEM", "collapses", "replay", "simplify"]

SYSTEM = System(
    name="edge_collapse",
    family="cluster",
    source="Garland & Heckbert 1997; blocks and rounds are ours",
    takes=(TriangleMesh,),
    prepare=prepare,
    cases={
        "tenth": Params(target_reduction=0.9),
        "blocks": Params(target_reduction=0.5, block=64),
        "rounds": Params(target_reduction=0.7, form="rounds"),
        "bound": Params(target_reduction=0.7, max_error=0.3),
        "border": Params(target_reduction=0.7, block=100, preserve_border=True, crease_angle=30.0),
    },
    verbs={"simplify": simplify},
)
