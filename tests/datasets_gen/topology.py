"""What a mesh is as a surface, counted edge by edge; judged by its own test below the others."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Topology:
    euler: int  # vertices in use - edges + triangles
    border: int  # edges with one triangle
    repeated: int  # directed edges that occur twice: non-manifold or turned over
    unused: int
    volume: float


def topology(mesh):
    triangles = mesh.triangles.astype(np.int64)
    a, b, c = triangles.T
    start, end = np.concatenate([a, b, c]), np.concatenate([b, c, a])
    count = mesh.vertex_count
    forward, backward = start * count + end, end * count + start
    edges = np.unique(np.minimum(forward, backward))
    used = len(np.unique(triangles))
    corners = mesh.positions.astype(np.float64)[triangles]
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    return Topology(
        used - len(edges) + len(triangles),
        int((~np.isin(forward, backward)).sum()),
        len(forward) - len(np.unique(forward)),
        count - used,
        float(volume),
    )


def soup(mesh):
    """The triangles as rows of nine coordinates, in order."""
    return mesh.positions[mesh.triangles].reshape(-1, 9)
