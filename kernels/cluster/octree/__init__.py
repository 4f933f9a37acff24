"""Quadric clustering on an octree: one vertex per cell, and cells as coarse as an error allows.

The finest grid's quadrics are summed upwards, so that every cell of every coarser grid has its own sum, representative
and error. A vertex goes to the coarsest cell on its way to the root whose error, and that of all cells in it, keeps to
a threshold, which is given, or found so that a number of triangles is left: for that the tree is built once. Flat parts
get large cells, creases small ones; a triangle survives when its corners lie in three cells, and no crack opens between
cells of different sizes, since a vertex has one cell.

The slides keep the tree in a hash table that may lose nodes (`probabilistic_octree`); here it holds all occupied cells,
sorted along the Morton curve. Quadrics are kept about the centres of their cells, which leaves float32 enough for the
errors. Which error decides is a reconstruction: the root of the total over the whole area, not over the node's own, was
the best of three on parts with flat areas.

Source: DeCoro & Tatarchuk, Real-time Mesh Simplification Using the GPU, I3D 2007, slides 29-33.
"""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.octree.host import Octree, prepare
from lodbench.kernels.cluster.octree.params import Params
from lodbench.kernels.cluster.prepare import simplifier
from lodbench.kernels.system import System

__all__ = ["Octree", "Params", "SYSTEM", "simplify"]

simplify = simplifier(prepare, Params)

SYSTEM = System(
    name="octree",
    family="cluster",
    source="DeCoro & Tatarchuk 2007, slides 29-33",
    takes=(TriangleMesh,),
    prepare=prepare,
    cases={
        "tenth": Params(target_reduction=0.9),
        "third": Params(target_reduction=0.67, levels=6),
        "error": Params(max_error=0.01, levels=6),
        "rms": Params(max_error=0.01, levels=5, rule="rms"),
        "total": Params(max_error=0.0002, levels=5, rule="total", remove_duplicates=True),
        "cubes": Params(target_reduction=0.9, shape="cubes", border="keep"),
    },
    verbs={"simplify": simplify},
)
