"""What belongs to the vertices of a mesh, carried to its clustered form: means, split where a seam would be smeared.

Vertices of a cell that edges of triangles join inside it are a piece. A seam of the input, an edge between islands of
texture coordinates or a hard edge, is two rows of vertices that no triangle joins, so in a cell its sides are pieces
of their own; so are the two sheets of a thin wall. Pieces of a cell that agree share the mean of their vertices; where
they differ clearly, the output vertex is there once for each, with the same position to the bit, and each corner of a
triangle takes that of its own side.

Pieces agree with the heaviest one, unless their mean normals are more than `APART_DEGREES` apart, their mean colours
more than `APART_COLOURS` in a channel, or their mean texture coordinates more than a walk across the cell changes them:
`APART_WALK` times the spread of its vertices, times the change per length along the edges there. Those that do not are
asked again, with the heaviest of them.

Source: none, a reconstruction; DeCoro & Tatarchuk 2007 and Rossignac & Borrel 1993 cluster positions alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from lodbench.datasets_gen.surfaces import ATTRIBUTES, TriangleMesh
from lodbench.kernels.cluster.turned import NO_VERTEX

APART_DEGREES = 40.0
APART_COLOURS = 0.25
APART_WALK = 4.0
_ROUNDS = 32  # sides of one cell; pieces beyond stand for themselves
_SAME_UVS = 1e-5  # what rounding makes of equal ones
_LEAST = 1e-6  # of the mean area: a triangle without area still has a say where it is alone

Index = NDArray[np.intp]
Real = NDArray[np.float64]


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
    weights = _weights(mesh, corners)
    piece_of, count = _pieces(corners, vertex_map)
    kept = np.flatnonzero((weights > 0) & (vertex_map != NO_VERTEX))
    sums = _Sums(mesh, kept, piece_of[kept], weights[kept], count)
    owner = np.full(count, -1, np.intp)
    owner[piece_of[kept]] = vertex_map[kept]
    side = _sides(mesh, corners, vertex_map, owner, sums)
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


def _weights(mesh: TriangleMesh, corners: Index) -> Real:
    """The area of the triangles at each vertex, up to a common factor; 0 where no triangle is."""
    low, high = mesh.box
    extent = float((high - low).max())
    scale = np.float32(0.5 ** float(np.frexp(extent)[1]) if extent > 0 else 1.0)
    x, y, z = (mesh.positions * scale).T.copy()
    a, b, c = corners
    ux, uy, uz = (axis[b] - axis[a] for axis in (x, y, z))
    vx, vy, vz = (axis[c] - axis[a] for axis in (x, y, z))
    area = np.sqrt(
        (uy * vz - uz * vy) ** 2 + (uz * vx - ux * vz) ** 2 + (ux * vy - uy * vx) ** 2
    ).astype(np.float64)
    mean = area.mean() if len(area) else 0.0
    area = np.maximum(area, _LEAST * mean if mean > 0 else 1.0)
    total = np.zeros(len(x))
    for k in corners:
        total += np.bincount(k, area, len(x))
    return total


def _pieces(corners: Index, vertex_map: NDArray[np.uint32]) -> tuple[Index, int]:
    """The piece of each vertex, (n,), and how many there are."""
    n = len(vertex_map)
    a, b, c = corners
    at, bt, ct = (vertex_map[k] for k in corners)
    ab, bc = at == bt, bt == ct
    ca = (ct == at) & ~ab
    start = np.concatenate([a[ab], b[bc], c[ca]])
    end = np.concatenate([b[ab], c[bc], a[ca]])
    graph = coo_array((np.ones(len(start), np.int8), (start, end)), shape=(n, n))
    count, piece_of = connected_components(graph, directed=False)
    return piece_of.astype(np.intp), int(count)


class _Sums:
    """Weighted sums of positions and attributes, a row each for a piece or a side."""

    def __init__(
        self, mesh: TriangleMesh, kept: Index, row: Index, weights: Real, count: int
    ) -> None:
        """Those over the vertices `kept` of the mesh, each with its row and its weight."""
        self.total = np.bincount(row, weights, count)
        self.sums: dict[str, Real] = {}
        for name in ("positions", *ATTRIBUTES):
            given = getattr(mesh, name)
            if given is None:
                continue
            columns = given[kept].T.astype(np.float64)
            if name == "normals":
                columns = _unit(columns)
            sums = [np.bincount(row, weights * x, count).astype(np.float64) for x in columns]
            self.sums[name] = np.stack(sums)

    def joined(self, row: Index) -> _Sums:
        """The sums of those that have the same `row`; itself where each has its own."""
        moved = np.flatnonzero(row != np.arange(len(row)))
        if not len(moved):
            return self
        result = object.__new__(_Sums)
        result.total = self.total.copy()
        result.sums = {name: sums.copy() for name, sums in self.sums.items()}
        for own in (result.total, *(row_ for sums in result.sums.values() for row_ in sums)):
            np.add.at(own, row[moved], own[moved])
        return result

    def means(self, name: str, rows: Index) -> Real:
        """(columns, len(rows)); normals of unit length."""
        sums = self.sums[name][:, rows]
        return _unit(sums) if name == "normals" else sums / self.total[rows]

    def values(self, rows: Index) -> dict[str, Any]:
        """Attributes by name, a row for each of `rows`."""
        return {
            name: np.ascontiguousarray(self.means(name, rows).T, dtype=np.float32)
            for name in self.sums
            if name != "positions"
        }


def _unit(columns: Real) -> Real:
    """Vectors of unit length, (3, n); (0, 0, 1) for those of none."""
    length = np.sqrt((columns**2).sum(0))
    none = length <= 1e-12 * max(length.max(initial=0), 1e-300)
    result = columns / np.where(none, 1, length)
    result[:, none] = ((0.0,), (0.0,), (1.0,))
    return result


def _sides(
    mesh: TriangleMesh,
    corners: Index,
    vertex_map: NDArray[np.uint32],
    owner: Index,
    sums: _Sums,
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
        sums: _Sums,
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
