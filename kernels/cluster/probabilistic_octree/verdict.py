"""Is a table, and what was cut from it, the reference's?"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lodbench.kernels.cluster.octree.verdict import DEPTH_TOLERANCE, ERROR_TOLERANCE
from lodbench.kernels.cluster.probabilistic_octree import reference
from lodbench.kernels.cluster.turned import first_of_each
from lodbench.kernels.system import Check

if TYPE_CHECKING:
    from lodbench.kernels.cluster.probabilistic_octree.host import ProbabilisticOctree


def verdict(made: ProbabilisticOctree) -> Check:
    """Same keys in all slots; same triangles where the reference is cut by the device's errors, which are its own
    but for rounding; and representatives, as in `octree`.
    """
    (mesh,) = made.result()
    given, params = made.mesh, made.params
    if not given.vertex_count:
        return Check(mesh.triangle_count == 0, "triangles of none", mesh.triangle_count, 0)
    table = reference.write(given, params)
    read = made.read_table()
    keys = read["keys"].astype(np.int64)
    held = keys[:, 0] > 0
    wrong = int((np.where(held, keys[:, 0], 0)[1:] != table.high[1:]).sum())
    wrong += int((np.where(held, -keys[:, 1], 0)[1:] != table.low[1:]).sum())
    if wrong:
        return Check(False, "slots with other keys than the reference's", wrong, 0)
    errors = read["errors"].astype(np.float64)
    cut = reference.cut if params.search == "linear" else reference.cut_binary
    nodes = cut(table, errors, made.limit, params)
    if not np.array_equal(nodes, read["nodes"]):
        wrong = int((nodes != read["nodes"]).sum())
        return Check(False, "vertices in other slots than the reference's", wrong, 0)
    corners = nodes[given.triangles].reshape(-1, 3)
    a, b, c = corners.T
    used, triangles = np.unique(corners[(a != b) & (b != c) & (c != a)], return_inverse=True)
    triangles = triangles.reshape(-1, 3)
    if params.remove_duplicates:
        triangles = triangles[first_of_each(triangles, len(used))]
    if not np.array_equal(triangles, mesh.triangles):
        return Check(False, "triangles as many and the same as the reference's",
                     mesh.triangle_count, len(triangles))  # fmt: skip
    finite = np.isfinite(table.errors)
    if not np.array_equal(finite, np.isfinite(errors)):
        return Check(False, "slots with an error where the reference has one", 1, 0)
    trace = np.trace(table.A, axis1=1, axis2=2)
    steady = finite & (table.margins >= 0.02) & (trace > 1e-5)
    unit = table.edges * (np.sqrt(trace) if params.rule == "total" else 1)
    off = (np.abs(errors[steady] - table.errors[steady]) / unit[steady]).max(initial=0)
    if off > ERROR_TOLERANCE:
        return Check(False, "node's error off the reference's, cells", float(off), ERROR_TOLERANCE)
    expected = table.grid.positions(table.points[used])
    step = (mesh.positions.astype(np.float64) - expected.astype(np.float64)) / table.grid.edge
    A = table.A[used] / np.maximum(trace[used], 1e-30)[:, None, None]
    depth = np.sqrt(np.maximum(np.einsum("ni,nij,nj->n", step, A, step), 0)) / table.edges[used]
    worst = float(depth[steady[used]].max(initial=0))
    tolerance = DEPTH_TOLERANCE + table.grid.rounding(expected)
    return Check(worst <= tolerance, "representative off the reference's, cells", worst, tolerance)
