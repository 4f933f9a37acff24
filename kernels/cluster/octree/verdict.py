"""Is a tree, and what was cut from it, the reference's?"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lodbench.kernels.cluster.octree import reference
from lodbench.kernels.system import Check

if TYPE_CHECKING:
    from lodbench.kernels.cluster.octree.host import Octree

# float32 sums about the centres, of a cell's edge; roots of differences of such sums, too
DEPTH_TOLERANCE = 1e-2
ERROR_TOLERANCE = 1e-2


def verdict(made: Octree) -> Check:
    """Same triangles where the reference is cut by the device's errors, which are its own but for rounding.

    Errors and representatives are compared in edges of their own cells, the latter by what the quadric sees, as in
    `quadric_clustering`; where the solve stood near the limit between two of its attempts, either is right.
    """
    (mesh,) = made.result()
    given, params = made._mesh, made.params  # pyright: ignore[reportPrivateUsage]
    if not given.vertex_count:
        return Check(mesh.triangle_count == 0, "triangles of none", mesh.triangle_count, 0)
    tree = reference.build(given, made.levels)
    expected = reference.errors(tree, given, params.measured, params.whole)
    got = made.read_tree()["errors"].astype(np.float64)
    if got.shape != expected.shape:
        return Check(False, "nodes as many as the reference's", len(got), len(expected))
    nodes = reference.cut(tree, got, made.limit)
    left, used, vertex_map = reference.emit(tree, given, nodes)
    same = np.array_equal(left.triangles, mesh.triangles) and left.vertex_count == mesh.vertex_count
    if not same or not np.array_equal(vertex_map, made.vertex_map()):
        return Check(False, "triangles as many and the same as the reference's",
                     mesh.triangle_count, left.triangle_count)  # fmt: skip
    trace = np.trace(tree.A, axis1=1, axis2=2)
    unit = tree.edges * (np.sqrt(trace) if params.measured == "total" else 1)
    either = tree.margins < 0.02
    below = either.copy()
    for node in range(len(below) - 1):
        below[tree.parents[node]] |= below[node]
    off_error = np.abs(got - expected) / np.maximum(unit, 1e-30)
    off_error[below | (trace <= 1e-12)] = 0
    off = (mesh.positions.astype(np.float64) - left.positions.astype(np.float64)) / tree.grid.edge
    A = tree.A[used] / np.maximum(trace[used], 1e-30)[:, None, None]
    depth = np.sqrt(np.maximum(np.einsum("ni,nij,nj->n", off, A, off), 0)) / tree.edges[used]
    depth[either[used]] = 0
    tolerance = DEPTH_TOLERANCE + tree.grid.rounding(left.positions)
    worst = float(depth.max(initial=0))
    if worst > tolerance:
        return Check(False, "representative off the reference's, cells", worst, tolerance)
    worst = float(off_error.max(initial=0))
    return Check(worst <= ERROR_TOLERANCE, "node's error off the reference's, cells", worst,
                 ERROR_TOLERANCE)  # fmt: skip
