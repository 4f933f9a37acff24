"""Is a simplified mesh the reference's? For the kernels and for the host form alike."""

from __future__ import annotations

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.quadric_clustering.reference import Reference
from lodbench.kernels.system import Check

WHAT = "representative off the reference's across its planes, cells"
# float32 sums of planes at up to some hundred cells from the grid's corner
DEPTH_TOLERANCE = 1e-2


def verdict(mesh: TriangleMesh, reference: Reference) -> Check:
    """Same triangles; and no representative off the reference's by more than the tolerance across its planes.

    Along a flat surface the minimum is soft: float32 and float64 may differ there by a fair part of a cell and lose
    nothing. What is measured is the distance that the quadric itself sees, sqrt(d^T (A / tr A) d), in units of the
    largest cell edge. Where float32 may have fallen on the other side of the limit that decides between a step and the
    next, either is right: there the representative must lie within that limit, one cell from the mean.
    """
    expected, grid = reference.mesh, reference.grid
    if mesh.triangles.shape != expected.triangles.shape or not np.array_equal(
        mesh.triangles, expected.triangles
    ):
        return Check(False, "triangles as many and the same as the reference's",
                     mesh.triangle_count, 0.0)  # fmt: skip
    if mesh.vertex_count != expected.vertex_count:
        return Check(False, "vertices as many as the reference's", mesh.vertex_count, 0.0)
    if not mesh.vertex_count:
        return Check(True, WHAT, 0.0, DEPTH_TOLERANCE)
    # float64 throughout: differences of positions far from the origin are exact
    off = (mesh.positions.astype(np.float64) - expected.positions.astype(np.float64)) / grid.edge
    trace = np.trace(reference.A, axis1=1, axis2=2)
    flat = trace <= 1e-30
    A = reference.A / np.where(flat, 1, trace)[:, None, None]
    depth = np.where(flat, (off**2).sum(1), np.einsum("ni,nij,nj->n", off, A, off))
    limits = np.maximum(reference.limits, 1e-30)
    either = reference.margins * limits.min(axis=1) < 0.02 + 4e-4 * grid.extent
    from_mean = np.linalg.norm((reference.points + off - reference.means) / limits, axis=1)
    depth[either & (from_mean <= 1.05)] = 0.0
    value = float(np.sqrt(np.maximum(depth, 0).max()))
    tolerance = DEPTH_TOLERANCE + grid.rounding(expected.positions)
    return Check(value <= tolerance, WHAT, value, tolerance)
