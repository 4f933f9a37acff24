"""What it costs at each vertex to be moved away from where normals, texture coordinates or colours bend or break.

Along a linear field nothing is lost by moving: it is interpolated. So each triangle at a vertex has a plane there that
is upright on how its gradient differs from the mean around the vertex: a field that bends, as at the edge of a spot of
colour, holds its vertices across the bend and not along it. Seams, where two triangles name different values at one
place, are held by planes upright on their edges, as borders are. These quadrics are added up as vertices join, from
sweep to sweep.

Source: ours; the gradients are those of Hoppe, New Quadric Metric for Simplifying Meshes with Appearance Attributes,
1999, who adds dimensions to the quadrics instead.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.edge_collapse.params import Params

Real = NDArray[np.float64]
KINDS = {"normal_weight": "normals", "uv_weight": "uvs", "colour_weight": "colours"}
UPPER = (0, 0, 0, 1, 1, 2), (0, 1, 2, 1, 2, 2)  # xx xy xz yy yz zz


def weighted(params: Params) -> bool:
    """Do attributes cost anything?"""
    return any(getattr(params, name) for name in KINDS)


def penalties(mesh: TriangleMesh, place: NDArray[np.intp], params: Params) -> Real:
    """Quadrics about each vertex, (places, 6) as xx xy xz yy yz zz, in units of length squared and area.

    Args:
        mesh: with the attributes.
        place: (n,), the vertex of each one of the mesh where those at one place are one, numbered in their first order.
        params: with the weights: the share of the diagonal that a change of 1 counts as.

    Raises:
        ValueError: a weight of what the mesh has not.
    """
    values = _values(mesh, params)
    corners = mesh.triangles.astype(np.intp)
    count = int(place.max(initial=-1)) + 1
    unit = mesh.diagonal or 1.0
    points = (mesh.positions.astype(np.float64) - mesh.box[0]) / unit
    sides = points[np.roll(corners, -1, 1)] - points[corners]
    normals = np.cross(sides[:, 0], sides[:, 1])
    squares = (normals**2).sum(1)
    whole = squares > 0
    corners, sides, normals = corners[whole], sides[whole], normals[whole]
    squares, areas = squares[whole], np.sqrt(squares[whole]) / 2
    change = values[corners[:, 1:]] - values[corners[:, :1]]  # (m, 2, fields)
    along = np.stack([np.cross(-sides[:, 2], normals), np.cross(normals, sides[:, 0])], 1)
    gradients = np.einsum("mka,mkx->max", change, along) / squares[:, None, None]
    at = place[corners]
    total = np.zeros((count, *gradients.shape[1:]))
    around = np.zeros(count)
    for k in range(3):
        np.add.at(total, at[:, k], gradients * areas[:, None, None])
        np.add.at(around, at[:, k], areas)
    mean = total / np.maximum(around, 1e-300)[:, None, None]
    units = normals / np.sqrt(squares)[:, None]
    found = np.zeros((count, 6))
    for k in range(3):
        own = mean[at[:, k]]
        off = gradients - own + np.einsum("max,mx,my->may", own, units, units)
        planes = np.einsum("max,may->mxy", off, off) * (areas / 3)[:, None, None]
        np.add.at(found, at[:, k], planes[:, UPPER[0], UPPER[1]])
    _add_seams(found, corners, at, values, sides, units)
    return found * unit**2


def _values(mesh: TriangleMesh, params: Params) -> Real:
    """What counts, each times its weight, side by side, (n, fields)."""
    fields = [np.zeros((mesh.vertex_count, 0))]
    for name, kind in KINDS.items():
        weight, values = getattr(params, name), getattr(mesh, kind)
        if weight and values is None:
            raise ValueError(f"{name}: expected a mesh with {kind}, got one without")
        if weight:
            fields.append(weight * values.astype(np.float64))
    return np.concatenate(fields, axis=1)


def _add_seams(
    found: Real,
    corners: NDArray[np.intp],
    at: NDArray[np.intp],
    values: Real,
    sides: Real,
    units: Real,
) -> None:
    """Planes upright on the edges at which the two triangles name different values, times their length squared."""
    start, end = at.ravel(), np.roll(at, -1, 1).ravel()
    own = np.stack([corners.ravel(), np.roll(corners, -1, 1).ravel()], 1)
    keys = np.minimum(start, end) * (int(at.max(initial=0)) + 1) + np.maximum(start, end)
    order = np.argsort(keys, kind="stable")
    one, two = order[:-1], order[1:]
    same = keys[one] == keys[two]
    one, two = one[same], two[same]
    there = values[own[two]]
    there = np.where((start[one] == start[two])[:, None, None], there, there[:, ::-1])
    parted = (values[own[one]] != there).any(axis=(1, 2))
    rows = np.concatenate([one[parted], two[parted]])
    edges = sides.reshape(-1, 3)[rows]
    upright = np.cross(edges, units[rows // 3])  # as long as the edge
    planes = (upright[:, :, None] * upright[:, None])[:, UPPER[0], UPPER[1]]
    np.add.at(found, start[rows], planes)
    np.add.at(found, end[rows], planes)
