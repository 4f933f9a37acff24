"""What belongs to the vertices of a mesh, carried to its clustered form: means, split where a seam would be smeared.

Pieces of a cell (`seams.py`) that agree share the mean of their vertices; where they differ clearly, the output vertex
is there once for each, with the same position to the bit, and each corner of a triangle takes that of its own side.

Source: none, a reconstruction; DeCoro & Tatarchuk 2007 and Rossignac & Borrel 1993 cluster positions alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import ATTRIBUTES, TriangleMesh
from lodbench.kernels.cluster.attribute_sums import AttributeSums, Index, vertex_weights
from lodbench.kernels.cluster.seams import mixed_vertices, pieces, sides
from lodbench.kernels.cluster.turned import NO_VERTEX


def has_attributes(mesh: TriangleMesh) -> bool:
    """Is there anything to carry?"""
    return any(getattr(mesh, name) is not None for name in ATTRIBUTES)


@dataclass(frozen=True)
class Carried:
    """A clustered mesh with attributes.

    Attributes:
        mesh: the output; the vertices that were split off come last, in the order of those they were split from.
        vertex_map: (n,) uint32, the output vertex of each input vertex on its own side.
        split: vertices that were split off.
    """

    mesh: TriangleMesh
    vertex_map: NDArray[np.uint32]
    split: int


def carry(
    mesh: TriangleMesh, simplified: TriangleMesh, vertex_map: NDArray[np.uint32], sources: Index
) -> Carried:
    """`simplified` with the normals, texture coordinates, colours and tags of `mesh`.

    An output vertex has the mean over the input vertices of its side, weighted by the area of the triangles at each;
    normals have unit length, (0, 0, 1) where they cancel out. Where no side differs clearly, positions and triangles
    are those of `simplified`.

    Args:
        mesh: the input, n vertices.
        simplified: positions and triangles of the output.
        vertex_map: (n,), output vertex of each input vertex, 0xFFFFFFFF where none.
        sources: (m,), the input triangle of each output triangle, corner by corner.
    """
    corners = mesh.triangles.T.astype(np.intp)
    weights = vertex_weights(mesh, corners)
    kept = np.flatnonzero((weights > 0) & (vertex_map != NO_VERTEX))
    count = simplified.vertex_count
    owned = vertex_map[kept].astype(np.intp)
    sums = AttributeSums(mesh, kept, owned, weights[kept], count)
    mixed = mixed_vertices(mesh, kept, owned, sums)
    piece_of, count = pieces(corners, vertex_map, mixed)
    if mixed.any():
        sums = AttributeSums(mesh, kept, piece_of[kept], weights[kept], count)
    owner = np.full(count, -1, np.intp)
    owner[piece_of[kept]] = vertex_map[kept]
    side = sides(mesh, corners, vertex_map, owner, sums)
    # the sides that corners have, one row each: those of a vertex follow each other
    side_of = side[piece_of]
    at = side_of[mesh.triangles[sources].astype(np.intp)].ravel()
    present = np.zeros(count, bool)
    present[at] = True
    rows = np.flatnonzero(present)
    rows = rows[np.argsort(owner[rows], kind="stable")]
    owners = owner[rows]
    first = np.ones(len(rows), bool)
    first[1:] = owners[1:] != owners[:-1]
    number = np.full(count, -1, np.intp)
    number[rows] = owners
    extra = rows[~first]
    number[extra] = simplified.vertex_count + np.arange(len(extra))
    values = sums.joined(side).values(np.concatenate([rows[first], extra]))
    positions, triangles = simplified.positions, simplified.triangles
    if len(extra):
        positions = np.concatenate([positions, positions[owner[extra]]])
        triangles = number[at].reshape(-1, 3).astype(np.uint32)
        own = number[side_of]
        vertex_map = np.where(own >= 0, own, vertex_map).astype(np.uint32)
    result = replace(simplified, positions=positions, triangles=triangles, **values)
    return Carried(result, vertex_map, len(extra))
