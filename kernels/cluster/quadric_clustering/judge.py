"""Is a simplified mesh the reference's? For the kernels and for the host form alike."""

from __future__ import annotations

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.quadric_clustering.reference import Reference
from lodbench.kernels.system import Check

# float32 sums of planes up to a few hundred cells from the origin, see `judge`
DEPTH_TOLERANCE = 1e-2


def judge(mesh: TriangleMesh, reference: Reference) -> Check:
    """Same triangles; and no representative off the reference's by more than the tolerance across its planes.

    Along a flat surface the minimum is soft: float32 and float64 may differ there by a fair part of a cell and lose
    nothing, and next to a threshold one may step where the other takes the mean. What is measured is the distance
    that the quadric itself sees, sqrt(d^T (A / tr A) d), in units of the largest cell edge.
    """
    expected = reference.mesh
    if (
        mesh.vertex_count != expected.vertex_count
        or mesh.triangle_count != expected.triangle_count
        or not np.array_equal(mesh.triangles, expected.triangles)
    ):
        return Check(False, "triangles as in the reference", mesh.triangle_count, 0.0)
    if not mesh.vertex_count:
        return Check(True, "representative off the reference, cells", 0.0, DEPTH_TOLERANCE)
    edge = float(reference.grid.unit) / reference.grid.prescale
    off = (mesh.positions.astype(np.float64) - expected.positions) / edge
    trace = np.trace(reference.A, axis1=1, axis2=2)
    flat = trace <= 1e-30
    A = reference.A / np.where(flat, 1, trace)[:, None, None]
    depth = np.einsum("ni,nij,nj->n", off, A, off)
    depth[flat] = (off[flat] ** 2).sum(1)
    value = float(np.sqrt(np.maximum(depth, 0).max()))
    # the corner of the box may be far away: positions are rounded there
    rounding = 4 * float(np.spacing(np.abs(expected.positions).max())) / edge
    tolerance = DEPTH_TOLERANCE + rounding
    return Check(value <= tolerance, "representative off the reference, cells", value, tolerance)
