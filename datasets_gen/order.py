"""The order of a mesh's triangles and vertices: sorted in space. The surface stays the same."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from trimesh.grouping import unique_rows

from lodbench.datasets_gen.arrays import box
from lodbench.datasets_gen.surfaces import TriangleMesh


def _spread(values: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """The low 21 bits of each value, two zero bits after each."""
    for shift, mask in (
        (32, 0x001F00000000FFFF),
        (16, 0x001F0000FF0000FF),
        (8, 0x100F00F00F00F00F),
        (4, 0x10C30C30C30C30C3),
        (2, 0x1249249249249249),
    ):
        values = (values | values << np.uint64(shift)) & np.uint64(mask)
    return values


def morton_codes(points: NDArray[np.floating]) -> NDArray[np.uint64]:
    """Place of each point, (n, 3), on the Z-order curve through their box, 21 bits per axis, (n,) uint64.

    Source: Morton 1966, A Computer Oriented Geodetic Data Base.
    """
    if not len(points):
        return np.zeros(0, np.uint64)
    low, high = box(points)
    extent = float((high - low).max())
    scale = (2**21 - 1) / extent if extent > 0 else 0.0
    x, y, z = (((points[:, axis] - low[axis]) * scale).astype(np.uint64) for axis in range(3))
    return _spread(x) | _spread(y) << np.uint64(1) | _spread(z) << np.uint64(2)


def spatially_sorted(mesh: TriangleMesh) -> TriangleMesh:
    """The same triangles in the Morton order of their centroids, vertices numbered by first use.

    The corners of a triangle keep their order; unused vertices come last, in order.
    """
    positions = mesh.positions.astype(np.float64)
    triangles = mesh.triangles
    centroids = positions[triangles[:, 0]]
    centroids += positions[triangles[:, 1]]
    centroids += positions[triangles[:, 2]]
    # stable: equal codes keep the input's order on every machine
    by_place = np.argsort(morton_codes(centroids), kind="stable")
    triangles = triangles[by_place]
    corners = triangles.ravel()
    # of equal indices the last write stays, so writing backwards leaves the first use
    first = np.full(mesh.vertex_count, len(corners), np.int64)
    first[corners[::-1]] = np.arange(len(corners) - 1, -1, -1)
    order = np.argsort(first, kind="stable")
    number = np.zeros(mesh.vertex_count, np.uint32)
    number[order] = np.arange(mesh.vertex_count, dtype=np.uint32)
    attributes = (mesh.normals, mesh.uvs, mesh.colours, mesh.tags)
    return TriangleMesh(
        mesh.positions[order],
        number[triangles],
        *(None if values is None else values[order] for values in attributes),
        edge_tags=None if mesh.edge_tags is None else mesh.edge_tags[by_place],
        origin=mesh.origin,
    )


def welded(mesh: TriangleMesh) -> TriangleMesh:
    """Points with equal coordinates become one, numbered by first use; the triangles stay, in order.

    Only positions and triangles remain: the other attributes may differ between the points joined.
    """
    points = mesh.positions + np.float32(0)  # -0 becomes 0
    lowest, point = unique_rows(points.view(np.int32), keep_order=True)
    return TriangleMesh(mesh.positions[lowest], point[mesh.triangles], origin=mesh.origin)
