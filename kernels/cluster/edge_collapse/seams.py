"""Vertices at one place, as where a seam of normals or colours parts them: one vertex, while a mesh is simplified."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.borders import places


def welded(mesh: TriangleMesh) -> tuple[TriangleMesh, NDArray[np.intp]]:
    """Positions and triangles with one vertex for each place, and the vertex of each one before, (n,).

    Where all places differ, the vertices are those of the mesh, in its order.
    """
    if _distinct(mesh):
        return mesh.bare(), np.arange(mesh.vertex_count)
    made, of = joined(mesh, np.arange(mesh.vertex_count), places(mesh.positions))
    return made.bare(), np.arange(mesh.vertex_count) if of is None else of


def joined(
    mesh: TriangleMesh, vertices: NDArray[np.integer], groups: NDArray[np.intp]
) -> tuple[TriangleMesh, NDArray[np.intp] | None]:
    """Positions and triangles with one vertex for each group, its first, in the mesh's order.

    Args:
        mesh: whose vertices are joined.
        vertices: (k,) ascending, those that are in groups; the others stay.
        groups: (k,) the group of each.

    Returns:
        The mesh, and the vertex of each one before, (n,); the mesh itself and None where no two are in a group.
    """
    _, first, group = np.unique(groups, return_index=True, return_inverse=True)
    if len(first) == len(vertices):
        return mesh, None
    own = np.arange(mesh.vertex_count)
    stands = own.copy()
    stands[vertices] = vertices[first[group]]
    kept = stands == own
    of = (np.cumsum(kept) - 1)[stands]
    triangles = of[mesh.triangles].astype(np.uint32).reshape(-1, 3)
    return TriangleMesh(mesh.positions[kept], triangles, origin=mesh.origin), of


def _distinct(mesh: TriangleMesh) -> bool:
    """Do all places differ for certain? Numbers made of them do; sorting these is far quicker than sorting places."""
    bits = (mesh.positions + np.float32(0)).view(np.uint32).astype(np.uint64)
    x, y, z = bits.T
    number = x * np.uint64(0x9E3779B97F4A7C15) + (
        y * np.uint64(0xC2B2AE3D27D4EB4F) ^ z << np.uint64(29)
    )
    number.sort()
    return not (number[1:] == number[:-1]).any()
