"""Vertices that a seam of normals, texture coordinates or colours parts: one, while the mesh is simplified."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh


def welded(mesh: TriangleMesh) -> tuple[TriangleMesh, NDArray[np.intp]]:
    """Positions and triangles with one vertex for each place, and the vertex of each one before, (n,).

    Where all places differ, the vertices are those of the mesh, in its order.
    """
    if _distinct(mesh):
        return mesh.bare(), np.arange(mesh.vertex_count)
    _, first, place = np.unique(
        mesh.positions + np.float32(0), axis=0, return_index=True, return_inverse=True
    )  # -0 is 0
    place = place.reshape(-1)
    if len(first) == mesh.vertex_count:
        return mesh.bare(), np.arange(mesh.vertex_count)
    order = np.argsort(first, kind="stable")
    number = np.empty_like(order)
    number[order] = np.arange(len(order))
    of = number[place]
    triangles = of[mesh.triangles].astype(np.uint32).reshape(-1, 3)
    return TriangleMesh(mesh.positions[first[order]], triangles, origin=mesh.origin), of


def _distinct(mesh: TriangleMesh) -> bool:
    """Do all places differ for certain? Numbers made of them do; sorting these is far quicker than sorting places."""
    bits = (mesh.positions + np.float32(0)).view(np.uint32).astype(np.uint64)
    x, y, z = bits.T
    number = x * np.uint64(0x9E3779B97F4A7C15) + (
        y * np.uint64(0xC2B2AE3D27D4EB4F) ^ z << np.uint64(29)
    )
    number.sort()
    return not (number[1:] == number[:-1]).any()
