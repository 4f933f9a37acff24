"""Is a tree, and what was cut from it, the reference's?"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lodbench.kernels.cluster.octree import reference
from lodbench.kernels.cluster.octree import reference_boxes as joined
from lodbench.kernels.system import Check

if TYPE_CHECKING:
    from lodbench.kernels.cluster.octree.host import Octree

# float32 sums about the centres, of a cell's edge; roots of differences of such sums, too
DEPTH_TOLERANCE = 1e-2
ERROR_TOLERANCE = 1e-2


def verdict(made: Octree) -> Check:
    """Same triangles as the reference has with what the device joined, and that is as cheap as the reference's own.

    Errors and representatives are compared in edges of their own cells, the latter by what the quadric sees, as in
    `quadric_clustering`; where the solve stood near the limit between two of its attempts, either is right.
    """
    (mesh,) = made.result()
    given, params = made._mesh, made.params  # pyright: ignore[reportPrivateUsage]
    if not given.vertex_count:
        return Check(mesh.triangle_count == 0, "triangles of none", mesh.triangle_count, 0)
    tree = reference.build(given, made.cells, made.levels, params.holds_border)
    expected = reference.errors(tree, given, params.measured)
    read = made.read_tree()
    got = read["errors"].astype(np.float64)
    if got.shape != expected.shape:
        return Check(False, "nodes as many as the reference's", len(got), len(expected))
    joins = read["joins"].view(np.int32).astype(np.int64)
    joins[-1] = joined.ALONE  # the root is joined to nothing
    nodes, cells = joined.cut(tree, joins), joined.cells_of(tree, joins)
    left, used, vertex_map = reference.emit(
        tree, given, nodes, cells.points, made.kept, params.remove_duplicates
    )
    same = np.array_equal(left.triangles, mesh.triangles) and left.vertex_count == mesh.vertex_count
    if not same or not np.array_equal(vertex_map, made.vertex_map()):
        return Check(False, "triangles as many and the same as the reference's",
                     mesh.triangle_count, left.triangle_count)  # fmt: skip
    trace = np.trace(tree.A, axis1=1, axis2=2)
    unit = tree.edges * (np.sqrt(trace) if params.measured == "total" else 1)
    off_error = np.abs(got - expected) / np.maximum(unit, 1e-30)
    either = tree.margins < 0.02
    off_error[either | (trace <= 1e-12)] = 0
    if params.measured == "maximum":  # which a node has from representatives of its own alone
        off_error[tree.edges * tree.grid.unit > 1e18] = 0
    worst = float(off_error.max(initial=0))
    if worst > ERROR_TOLERANCE:
        return Check(False, "node's error off the reference's, cells", worst, ERROR_TOLERANCE)
    own = used[: len(used) - np.count_nonzero(used >= len(got))]
    positions = mesh.positions[: len(own)].astype(np.float64)
    off = (positions - left.positions[: len(own)].astype(np.float64)) / tree.grid.edge
    depth = np.sqrt(np.maximum(joined.depths(tree, joins, own, off), 0)) / cells.edges[own]
    depth[cells.margins[own] < 0.02] = 0
    tolerance = DEPTH_TOLERANCE + tree.grid.rounding(left.positions)
    worst = float(depth.max(initial=0))
    if worst > tolerance:
        return Check(False, "representative off the reference's, cells", worst, tolerance)
    return _cheap(made, tree, got, nodes, cells)


def _cheap(
    made: Octree, tree: reference.Tree, got: np.ndarray, nodes: np.ndarray, cells: joined.Cells
) -> Check:
    """What the vertices cost against the least that the reference finds, for the same errors of the cubes."""
    rule = made.params.measured
    _, least = joined.choose(tree, got, made.limit, rule, made.params.boxed)
    used = np.unique(nodes)
    price = made.limit**2 if rule == "total" else 1.0
    cost = price * len(used)
    if rule == "total":
        cost += float(np.where(cells.boxes, cells.energies, got**2)[used].sum())
    # float32 sums decide between what costs nearly the same; boxes that are left unsolved may have been cheaper, by 1 %
    # of the whole where few vertices are left
    room = 2e-2 * abs(least) + 3e-7 * float((cells.areas * cells.edges**2)[used].sum()) + 1e-30
    if rule == "rms":
        room += 0.01 * len(used)
    return Check(cost <= least + room, "cost over the least", cost, least + room)
