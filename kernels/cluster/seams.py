"""Where a cell holds more than one side of a surface: pieces that no triangle joins, and which of them differ clearly.

Vertices of a cell that edges of triangles join inside it are a piece. A seam of the input, an edge between islands of
texture coordinates or a hard edge, is two rows of vertices that no triangle joins, so in a cell its sides are pieces
of their own; so are the two sheets of a thin wall.

Pieces agree with the heaviest one, unless their mean normals are more than `APART_DEGREES` apart, their mean colours
more than `APART_COLOURS` in a channel, or their mean texture coordinates more than a walk across the cell changes them:
`APART_WALK` times the spread of its vertices, times the change per length along the edges there. Those that do not are
asked again, with the heaviest of them.

Source: none, a reconstruction.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.attribute_sums import AttributeSums, Index, Real
from lodbench.kernels.cluster.turned import NO_VERTEX

APART_DEGREES = 40.0
APART_COLOURS = 0.25
APART_WALK = 4.0
_ROUNDS = 32  # sides of one cell; pieces beyond stand for themselves
_SAME_UVS = 1e-5  # what rounding makes of equal ones


def mixed_vertices(
    mesh: TriangleMesh, kept: Index, owner: Index, sums: AttributeSums
) -> NDArray[np.bool_]:
    """Of which output vertices may pieces differ clearly? Not where no vertex is half as far from the mean.

    Args:
        mesh: the input.
        kept: its vertices that count.
        owner: their output vertices.
        sums: of these.
    """
    rows = np.arange(len(sums.total))
    mixed = np.zeros(len(rows), bool)
    if mesh.uvs is not None:  # how far is too far is known only of what is asked about
        mixed[:] = True
        return mixed
    if mesh.normals is not None:
        own = mesh.normals[kept].T
        along = (sums.means("normals", rows).astype(np.float32)[:, owner] * own).sum(0)
        least = np.float32(np.cos(np.radians(APART_DEGREES / 2 - 0.01)))  # 0.01: for rounding
        mixed[owner[along <= least * np.sqrt((own**2).sum(0))]] = True
    if mesh.colours is not None:
        mean = sums.means("colours", rows)
        for axis, own in zip(mean, mesh.colours[kept].T, strict=True):
            mixed[owner[np.abs(axis[owner] - own) > APART_COLOURS / 2]] = True
    return mixed


def pieces(
    corners: Index, vertex_map: NDArray[np.uint32], mixed: NDArray[np.bool_]
) -> tuple[Index, int]:
    """The piece of each vertex, (n,), and how many there are: all of an output vertex, unless it is `mixed`.

    A vertex that goes nowhere is in the last piece.
    """
    asked = np.append(mixed, False)[np.minimum(vertex_map, np.uint32(len(mixed)))]
    among = np.flatnonzero(asked)
    number = np.zeros(len(vertex_map), np.intp)
    number[among] = np.arange(len(among))
    start, end = [], []
    for one, other in ((0, 1), (1, 2), (2, 0)):
        a, b = corners[one], corners[other]
        inside = np.flatnonzero(asked[a] & (vertex_map[a] == vertex_map[b]))
        start.append(number[a[inside]])
        end.append(number[b[inside]])
    ends = np.concatenate(start), np.concatenate(end)
    size = len(among), len(among)
    graph = coo_array((np.ones(len(ends[0]), np.int8), ends), shape=size)
    count, component = connected_components(graph, directed=False)
    piece_of = np.minimum(vertex_map, np.uint32(len(mixed))).astype(np.intp)
    piece_of[vertex_map == NO_VERTEX] = len(mixed) + count
    piece_of[among] = len(mixed) + component
    return piece_of, len(mixed) + int(count) + 1


def sides(
    mesh: TriangleMesh,
    corners: Index,
    vertex_map: NDArray[np.uint32],
    owner: Index,
    sums: AttributeSums,
) -> Index:
    """The side of each piece: the number of the piece that leads it."""
    side = np.arange(len(owner))
    there = np.flatnonzero(owner >= 0)
    alone = np.bincount(owner[there], minlength=1) < 2
    open_ = there[~alone[owner[there]]]
    if not len(open_):
        return side
    # the pieces of an owner follow each other, the heaviest first
    open_ = open_[np.lexsort((open_, -sums.total[open_], owner[open_]))]
    apart = _Apart(mesh, corners, vertex_map, ~alone, sums, open_)
    left = np.arange(len(open_))
    for _ in range(_ROUNDS):
        if not len(left):
            break
        owners = owner[open_[left]]
        begins = np.r_[True, owners[1:] != owners[:-1]]
        leader = left[np.flatnonzero(begins)[np.cumsum(begins) - 1]]
        far = apart(leader, left, owners)
        side[open_[left[~far]]] = open_[leader[~far]]
        left = left[far]
    return side


class _Apart:
    """Do pieces of one output vertex differ clearly? Asked of rows of `pieces`."""

    def __init__(
        self,
        mesh: TriangleMesh,
        corners: Index,
        vertex_map: NDArray[np.uint32],
        several: NDArray[np.bool_],
        sums: AttributeSums,
        pieces: Index,
    ) -> None:
        self.means = {name: sums.means(name, pieces) for name in sums.sums if name != "tags"}
        self.walk = np.zeros(0)
        if mesh.uvs is not None:
            self.walk = _uv_walk(mesh, corners, vertex_map, several)

    def __call__(self, a: Index, b: Index, owners: Index) -> NDArray[np.bool_]:
        found = np.zeros(len(a), bool)
        if (normals := self.means.get("normals")) is not None:
            found |= (normals[:, a] * normals[:, b]).sum(0) < np.cos(np.radians(APART_DEGREES))
        if (colours := self.means.get("colours")) is not None:
            found |= np.abs(colours[:, a] - colours[:, b]).max(0) > APART_COLOURS
        if (uvs := self.means.get("uvs")) is not None:
            step = np.sqrt(((uvs[:, a] - uvs[:, b]) ** 2).sum(0))
            found |= step > APART_WALK * self.walk[owners] + _SAME_UVS
        return found


def _uv_walk(
    mesh: TriangleMesh,
    corners: Index,
    vertex_map: NDArray[np.uint32],
    several: NDArray[np.bool_],
) -> Real:
    """How far texture coordinates go over the spread of an output vertex' input vertices, root mean square.

    Args:
        mesh: the input.
        corners: its triangles, (3, m).
        vertex_map: output vertex of each input vertex.
        several: output vertices asked about.
    """
    assert mesh.uvs is not None
    count = len(several)
    asked = np.zeros(len(vertex_map), bool)
    mapped = vertex_map < count
    asked[mapped] = several[vertex_map[mapped]]
    length, change = np.zeros(count), np.zeros(count)
    for start, end in ((0, 1), (1, 2), (2, 0)):
        some = asked[corners[start]]
        a, b = corners[start, some], corners[end, some]
        for total, values in ((length, mesh.positions), (change, mesh.uvs)):
            step = values[b].astype(np.float64) - values[a]
            total += np.bincount(vertex_map[a], np.sqrt((step**2).sum(1)), count)
    rows = np.flatnonzero(asked)
    own = vertex_map[rows].astype(np.intp)
    members = np.maximum(np.bincount(own, minlength=count), 1)
    spread = np.zeros(count)
    for axis in mesh.positions[rows].T.astype(np.float64):
        middle = np.bincount(own, axis, count) / members
        spread += np.bincount(own, (axis - middle[own]) ** 2, count) / members
    return np.sqrt(spread) * change / np.where(length > 0, length, 1)
