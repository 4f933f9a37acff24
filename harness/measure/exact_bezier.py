"""Figures of tessellated Bezier patches: points and normals against float64, borders, and who agrees with whom."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from lodbench.datasets_gen.surfaces import BezierPatches, Floats, TriangleMesh
from lodbench.harness.measure.figure import Figure, Seen
from lodbench.kernels.bezier.borders import borders_of
from lodbench.kernels.bezier.measures import inverse_diagonal
from lodbench.kernels.bezier.reference import points_at
from lodbench.kernels.exactness import NORMAL, NORMAL_LIMIT, POSITION, POSITION_LIMIT
from lodbench.kernels.opencl import Unsupported
from lodbench.kernels.system import Prepared

Doubles = NDArray[np.float64]

AT_RIM = 5e-4  # of the diagonal: so near the open borders are both ends of an edge that may be open
STEPS = 4096  # along an open border


def points(seen: Seen) -> Figure:
    """The largest error of a coordinate, as the subject's own check found it."""
    return Figure(_part(seen, POSITION), POSITION_LIMIT, _share_seen(seen))


def normals(seen: Seen) -> Figure:
    """The largest angle, degrees, away from degenerate points, as the subject's own check found it."""
    return Figure(_part(seen, NORMAL), float(np.rad2deg(NORMAL_LIMIT)), _share_seen(seen))


def _part(seen: Seen, name: str) -> float:
    if name not in seen.check.parts:
        raise Unsupported(
            f"needs a check of points and normals, subject has one of {seen.check.what}"
        )
    return seen.check.parts[name]


def _share_seen(seen: Seen) -> str:
    return seen.check.what.rpartition(", ")[2]


def cracks(seen: Seen) -> Figure:
    """Edges of triangles that no other triangle has, but for those along borders of one patch alone; none is to be."""
    return replace(open_inside(seen), limit=0)


def open_inside(seen: Seen) -> Figure:
    """As `cracks`, of rivals, which have promised nothing."""
    ends = np.concatenate(
        [np.zeros((0, 2, 3)), *(open_edges(mesh, False) for mesh in seen.prepared.result())]
    )
    rim = open_borders(seen.surface)
    at_rim = near(ends, KDTree(rim), AT_RIM / inverse_diagonal(seen.surface.points))
    return Figure(int((~at_rim).sum()), None, f"{int(at_rim.sum()):,} more at open borders")


def near(ends: Doubles, rim: KDTree, distance: float) -> NDArray[np.bool_]:
    """Which edges, (n, 2, 3), have both ends so near a point of `rim`."""
    return (rim.query(ends.reshape(-1, 3))[0].reshape(-1, 2) <= distance).all(axis=1)


def open_edges(mesh: TriangleMesh, turned: bool = True) -> Doubles:
    """Edges, by the bits of their ends, that an odd number of triangles has, (n, 2, 3).

    With `turned`, those that triangles do not use as often one way as the other.
    """
    vertex = _numbered(mesh.positions)
    t = vertex[mesh.triangles]
    pairs = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    pairs = pairs[pairs[:, 0] != pairs[:, 1]]
    most = vertex.max(initial=0) + 1
    key = pairs.min(axis=1) * most + pairs.max(axis=1)
    sign = np.where(pairs[:, 0] < pairs[:, 1], 1, -1) if turned else np.ones(len(pairs), np.int64)
    _, first, number = np.unique(key, return_index=True, return_inverse=True)
    uses = np.bincount(number.reshape(-1), sign, len(first)).astype(np.int64)
    ends = np.zeros((most, 3))
    ends[vertex] = mesh.positions
    return ends[pairs[first[uses != 0 if turned else uses % 2 == 1]]]


def _numbered(points: Floats) -> NDArray[np.int64]:
    """The number of each point's place among all that there are, by its bits, (n,)."""
    bits = np.ascontiguousarray(points + np.float32(0)).view(np.uint32)
    order = np.lexsort(bits.T)
    new = (np.diff(bits[order], axis=0) != 0).any(axis=1)
    number = np.zeros(len(points), np.int64)
    number[order[1:]] = np.cumsum(new)
    return number


def open_borders(patches: BezierPatches) -> Doubles:
    """Points along the borders of one patch alone, (n, 3)."""
    borders = borders_of(patches.points)
    uses = np.bincount(borders.curve.ravel(), minlength=borders.curve.size + 1)
    alone = (uses[borders.curve] == 1) & ~borders.collapsed
    t = np.arange(STEPS + 1) / STEPS
    sides = [(0 * t, t), (0 * t + 1, t), (t, 0 * t), (t, 0 * t + 1)]
    P = patches.points.astype(np.float64)
    found = [points_at(P[alone[:, e]], u, v).reshape(-1, 3) for e, (u, v) in enumerate(sides)]
    return np.concatenate(found)


def unlike_vertices(seen: Seen) -> Figure:
    """Virtual vertices of patches that this subject has not where the group's first has them, or that it has not."""
    ours, theirs = _on_patches(seen.prepared), _on_patches(_first(seen))
    size = 1 / inverse_diagonal(seen.surface.points)
    places, points = theirs
    count = int(places.max(initial=-1)) + 1
    expected = np.full((len(points), count, 3), np.nan)
    expected[:, places] = points
    places, points = ours
    alike = np.zeros((len(points), count), np.bool_)
    alike[:, places] = True
    off = np.abs(points - expected[:, places]).max(axis=2)
    patch, slot = np.nonzero(~(off <= POSITION_LIMIT * size))  # NaN is none of theirs
    alike[patch, places[slot]] = False
    return Figure(int((~alike).sum()), 0, f"{alike.size:,} vertices")


def _on_patches(prepared: Any) -> tuple[NDArray[np.int64], Doubles]:
    """Which virtual vertex each slot of a patch has, and the points there, (patches, slots, 3)."""
    places = prepared.arrangement.places
    (mesh,) = prepared.result()
    return places, mesh.positions.reshape(-1, len(places), 3).astype(np.float64)


def unlike_bytes(seen: Seen) -> Figure:
    """Bytes of points, normals and triangles that differ from those of the group's first subject."""
    ours, theirs = (_bytes(prepared) for prepared in (seen.prepared, _first(seen)))
    size = min(len(ours), len(theirs))
    differ = np.count_nonzero(ours[:size] != theirs[:size]) + abs(len(ours) - len(theirs))
    return Figure(int(differ), 0, f"{len(theirs):,} bytes")


def _first(seen: Seen) -> Prepared:
    if seen.first is None:
        raise Unsupported("needs the group's first subject, which did not run")
    return seen.first


def _bytes(prepared: Prepared) -> NDArray[np.uint8]:
    (mesh,) = prepared.result()
    arrays = [mesh.positions, mesh.triangles, *([] if mesh.normals is None else [mesh.normals])]
    return np.concatenate([np.frombuffer(array.tobytes(), np.uint8) for array in arrays])
