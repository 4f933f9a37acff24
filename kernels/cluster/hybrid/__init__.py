"""Clustering first, then edge collapse of what it leaves: much of the latter's quality in a fraction of its time.

A grid joins vertices to a few times the target, in one walk over the triangles. Cells that would change the surface,
where sheets meet or a neck is cut, are taken apart into their vertices again (`joined.py`), so that a closed manifold
stays one, of the same genus; where that fails, seen by the number of vertices - edges + triangles, the clustering is
done anew with twice the triangles, and in the end left out. Border vertices stay single. Edge collapse goes on from
there.

Source: Garland & Shaffer, A Multiphase Approach to Efficient Surface Simplification, Visualization 2002, for both in
one; DeCoro & Tatarchuk, I3D 2007, for the clustering; Garland & Heckbert, SIGGRAPH 97, for the collapses. Taking cells
apart and the factor between both stages are our own; that was chosen on armadillo_86k, mechpart_g3, fandisk and a
displaced sphere.
"""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.hybrid.host import Hybrid, prepare
from lodbench.kernels.cluster.hybrid.params import Params
from lodbench.kernels.cluster.hybrid.simplify import simplify
from lodbench.kernels.system import System

__all__ = ["Hybrid", "Params", "SYSTEM", "simplify"]

SYSTEM = System(
    name="hybrid",
    family="cluster",
    source="Garland & Shaffer 2002; taking cells apart is ours",
    takes=(TriangleMesh,),
    prepare=prepare,
    cases={
        "tenth": Params(target_reduction=0.9),
        "octree": Params(target_reduction=0.9, first="octree", factor=3.0),
        "border": Params(target_reduction=0.8, factor=1.5, preserve_border=True),
    },
    verbs={"simplify": simplify},
)
