"""Quadric clustering on an octree: one vertex per cell, and cells as large as their error is worth.

The finest grid's quadrics are summed upwards, so that every cube of every coarser grid has its own sum, representative
and error. From the finest cubes up, each one then gets the cheapest of three: one vertex; one for each of a few boxes,
its halves, quarters and so on, that its children are joined to; or what its children have. A vertex costs its quadric
error and a price, which is found so that a number of triangles is left, the tree being built once; where an error is
given instead, cells keep to it and are as few as that allows. Flat parts get large cells, creases small ones, and what
bends one way cells that are longer the other way. A triangle survives when its corners lie in three cells, and no crack
opens between cells of different sizes, since a vertex has one cell.

The slides keep the tree in a hash table that may lose nodes (`probabilistic_octree`); here it holds all occupied cells,
sorted along the Morton curve. Quadrics are kept about the centres of their cells, which leaves float32 enough for the
errors. What a node costs, boxes, and the planes that hold borders are reconstructions; slide 31 leaves the error open.

Source: DeCoro & Tatarchuk, Real-time Mesh Simplification Using the GPU, I3D 2007, slides 29-33; Breiman, Friedman,
Olshen & Stone, Classification and Regression Trees, 1984, chapter 3, for pruning at a price for each leaf.
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
