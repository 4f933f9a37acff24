"""Control points and normals of curved PN triangles in the order that shaders and matrix products take them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Floats, TriangleMesh
from lodbench.kernels.refine.pn_triangles.reference import (
    control_normals,
    control_points,
    cubic_points,
    quadratic_normals,
)

POINTS = ("b300", "b030", "b003", "b210", "b120", "b021", "b012", "b102", "b201", "b111")
NORMALS = ("n200", "n020", "n002", "n110", "n011", "n101")


def controls(mesh: TriangleMesh) -> tuple[Floats, Floats]:
    """Control points (m, 10, 3) and normals (m, 6, 3) of each triangle of a canonical mesh, float32.

    They are made in float64 and rounded once, in the order of `POINTS` and `NORMALS`.

    Source: Vlachos et al. 2001, sections 3.1 and 3.3.
    """
    P = mesh.positions[mesh.triangles].astype(np.float64)
    N = np.asarray(mesh.normals, np.float64)[mesh.triangles]
    points, normals = control_points(P, N), control_normals(P, N)
    return (
        np.stack([points[name] for name in POINTS], axis=1).astype(np.float32),
        np.stack([normals[name] for name in NORMALS], axis=1).astype(np.float32),
    )


def control_weights(wuv: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """What (w, u, v), (n, 3), gives each control point (n, 10) and each control normal (n, 6), float64."""
    points = {name: one[None] for name, one in zip(POINTS, np.eye(10), strict=True)}
    normals = {name: one[None] for name, one in zip(NORMALS, np.eye(6), strict=True)}
    return cubic_points(points, wuv)[0], quadratic_normals(normals, wuv)[0]
