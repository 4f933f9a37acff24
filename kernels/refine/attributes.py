"""What goes up of every coarse triangle, in the order in which neighbours evaluate their edge alike."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lodbench.datasets_gen.surfaces import Floats, TriangleMesh


def canonical(mesh: TriangleMesh) -> TriangleMesh:
    """`mesh` with normals, each triangle turned so that its lowest vertex number comes first.

    An edge is evaluated from its lower end in both of its triangles, so that they agree to the bit (a product below
    the smallest float32 may leave a zero of either sign). Zeros lose their sign, which would tell the two sides apart,
    and normals get unit length.
    """
    mesh = mesh.with_normals()
    normals = np.asarray(mesh.normals, np.float64).reshape(-1, 3)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    unit = np.where(length > 0, normals / np.where(length > 0, length, 1), (0.0, 0.0, 1.0))
    unit = np.where(np.abs(length - 1) < 1e-6, normals, unit).astype(np.float32)
    turn = (mesh.triangles.argmin(axis=1)[:, None] + np.arange(3)) % 3
    triangles = np.take_along_axis(mesh.triangles, turn, axis=1)
    edge_tags = mesh.edge_tags
    if edge_tags is not None:
        edge_tags = np.take_along_axis(edge_tags, turn[:, :, None], axis=1)
    zero = np.float32(0)
    return replace(
        mesh, positions=mesh.positions + zero, triangles=triangles, normals=unit + zero,
        edge_tags=edge_tags,
    )  # fmt: skip


def corner_attributes(mesh: TriangleMesh) -> Floats:
    """Of each triangle of a canonical mesh P0 P1 P2 N0 N1 N2, and 1 where edge P1 P2 begins at P2; (m, 19) float32."""
    corners, normals = mesh.triangles, np.asarray(mesh.normals, np.float32).reshape(-1, 3)
    return np.concatenate(
        [
            mesh.positions[corners].reshape(-1, 9),
            normals[corners].reshape(-1, 9),
            (corners[:, 1] > corners[:, 2])[:, None],
        ],
        axis=1,
        dtype=np.float32,
    )
