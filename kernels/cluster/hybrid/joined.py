"""A clustered mesh that is the surface it was: cells that would change it are taken apart into their vertices.

Each vertex has a label, its cell's output vertex. Where the triangles around one are not one fan, the cell has joined
what must stay apart: it is split in eight, and parts that are no fan either into their vertices, until every group that
is left is one fan. Vertices of cells that no triangle uses are by themselves from the start. What comes out is closed
where the input is, and manifold; what a cell can still hide, a handle within it, changes the number of vertices - edges
+ triangles, which is compared.

Source: none, a reconstruction; the test is that of a combinatorial manifold.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.links import troubled
from lodbench.kernels.cluster.turned import NO_VERTEX
from lodbench.kernels.opencl import Buffer, Device, Timeline
from lodbench.kernels.stages.scan import chunk_count, chunk_local

FILE = "cluster/hybrid/geometry.cl"
ROUNDS = 30  # each takes some cells apart; three or four are the rule
Index = NDArray[np.intp]


@dataclass(frozen=True)
class Joined:
    """A mesh of cells and of single vertices.

    Attributes:
        mesh: positions and triangles; every vertex is used.
        vertex_map: (n,) its vertex of each input vertex, 0xFFFFFFFF where no triangle has it.
        sources: (m,) the input triangle of each triangle, ascending.
        apart: its vertices that are less than a cell.
        surface: around every vertex is one fan.
    """

    mesh: TriangleMesh
    vertex_map: NDArray[np.uint32]
    sources: NDArray[np.uint32]
    apart: int
    surface: bool


def joined(
    device: Device,
    triangles: Buffer,
    positions: NDArray[np.float32],
    clustered: TriangleMesh,
    vertex_map: NDArray[np.uint32],
    locked: NDArray[np.bool_] | None = None,
) -> Joined:
    """The clustered mesh with the cells that change the surface taken apart.

    Args:
        device: where the input is.
        triangles: of the input, uint32 (m, 3).
        positions: of the input, (n, 3).
        clustered: what a clustering made of it.
        vertex_map: (n,) its vertex of each input vertex, 0xFFFFFFFF where there is none.
        locked: (n,) vertices that stay by themselves.
    """
    cells = clustered.vertex_count
    groups = Groups(positions, clustered.positions, vertex_map)
    groups.single(vertex_map == NO_VERTEX if locked is None else locked | (vertex_map == NO_VERTEX))
    bad = troubled(device, clustered.triangles, cells)
    for _ in range(ROUNDS):
        groups.split(bad)
        left, rows = _join(device, triangles, groups.labels)
        found = _troubled_near(device, left, cells, groups.count)
        bad = found & ~groups.whole
        if not bad.any():
            break
    used = np.zeros(groups.count + 1, bool)
    used[left.reshape(-1)] = True
    numbers = np.where(used, np.cumsum(used) - 1, NO_VERTEX).astype(np.uint32)
    mesh = TriangleMesh.of_kernels(groups.places()[used[:-1]], numbers[left])
    return Joined(mesh, numbers[groups.labels], rows, groups.apart, not found.any())


class Groups:
    """Which vertices are one: those of a cell, or of a part of one.

    Attributes:
        labels: (n,) uint32, the group of each vertex.
        whole: (groups,), it is known to be a single vertex.
        apart: groups that are less than a cell.
    """

    def __init__(
        self,
        positions: NDArray[np.float32],
        places: NDArray[np.float32],
        vertex_map: NDArray[np.uint32],
    ) -> None:
        self.labels = vertex_map.copy()
        self.whole = np.zeros(len(places), bool)
        self.apart = 0
        self._positions, self._places = positions, [places]
        self._halved = np.zeros(len(places), bool)

    @property
    def count(self) -> int:
        return len(self.whole)

    def places(self) -> NDArray[np.float32]:
        """Where the groups are, (count, 3): a cell's representative, or one of a part's own vertices."""
        return np.concatenate(self._places)

    def single(self, asked: NDArray[np.bool_]) -> None:
        """Make groups of their own of these vertices, (n,)."""
        self._add(np.flatnonzero(asked))

    def split(self, bad: NDArray[np.bool_]) -> None:
        """Split groups, (count,): a cell in eight by the middle of its vertices' box, a part into its vertices."""
        if not bad.any():
            return
        there = np.flatnonzero(np.append(bad, np.zeros(self.count - len(bad), bool))[self.labels])
        halved = self._halved[self.labels[there]]
        self._add(there[halved])
        there = there[~halved]
        there = there[np.argsort(self.labels[there], kind="stable")]
        group, first, middle = self._boxes(there, self.labels[there])
        side = (self._positions[there] > middle[group]) @ np.array([1, 2, 4])
        part = group * 8 + side
        there, part = (values[np.argsort(part, kind="stable")] for values in (there, part))
        group, first, middle = self._boxes(there, part)
        off = ((self._positions[there] - middle[group]) ** 2).sum(axis=1)
        nearest = there[np.lexsort((there, off, group))[first]]
        self._add(nearest, there, group, np.diff(np.append(first, len(there))) == 1)

    def _boxes(
        self, there: Index, keys: NDArray[np.integer]
    ) -> tuple[Index, Index, NDArray[np.float64]]:
        """Of vertices sorted by a key: the number of each one's run, first rows of runs, middles of their boxes."""
        starts = np.ones(len(there), bool)
        starts[1:] = keys[1:] != keys[:-1]
        first = np.flatnonzero(starts)
        points = self._positions[there].astype(np.float64)
        ends = [least.reduceat(points, first) for least in (np.minimum, np.maximum)]
        return np.cumsum(starts) - 1, first, (ends[0] + ends[1]) / 2

    def _add(
        self,
        places: Index,
        there: Index | None = None,
        group: Index | None = None,
        whole: NDArray[np.bool_] | None = None,
    ) -> None:
        """More groups, at the places of these vertices: which vertices are in which, and which groups are single."""
        more = len(places)
        if there is None or group is None or whole is None:
            there, group, whole = places, np.arange(more), np.ones(more, bool)
        self.labels[there] = (self.count + group).astype(np.uint32)
        self.whole = np.append(self.whole, whole)
        self._halved = np.append(self._halved, np.ones(more, bool))
        self._places.append(self._positions[places])
        self.apart += more


def _troubled_near(
    device: Device, triangles: NDArray[np.uint32], cells: int, count: int
) -> NDArray[np.bool_]:
    """Vertices that are not one fan among those with a triangle at a single vertex: no other has changed."""
    near = np.zeros(count, bool)
    near[triangles[_any(triangles >= cells)].reshape(-1)] = True
    found = troubled(device, triangles[_any(near[triangles])], count)
    return found & near


def _any(corners: NDArray[np.bool_]) -> NDArray[np.bool_]:
    return corners[:, 0] | corners[:, 1] | corners[:, 2]


def _join(
    device: Device, triangles: Buffer, labels: NDArray[np.uint32]
) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
    """Triangles of three labels, (k, 3), and their numbers in the input, (k,), ascending."""
    count = triangles.shape[0]
    out = device.allocate("joined", (count, 3), np.uint32)
    rows = device.allocate("rows", count, np.uint32)
    given = device.upload("labels", labels, np.uint32, lent=True)
    found = _over(device, "join", triangles, 2, "bounds", labels=given, joined=out, rows=rows)
    ends = found.reshape(-1, 2).tolist()
    left, numbers = device.read_all((out, None), (rows, None))
    return (
        np.concatenate([left[a:b] for a, b in ends]),
        np.concatenate([numbers[a:b] for a, b in ends]),
    )


def euler_but_border(device: Device, triangles: Buffer, vertex_count: int) -> int:
    """Twice vertices - edges + triangles of a mesh on the device, and its border edges, where no edge is crowded."""
    used = device.allocate("used", vertex_count, np.uint8)
    device.fill(Timeline(), "topology", used, 0)
    whole = _over(device, "used", triangles, 1, "whole", used=used)
    return 2 * int(np.count_nonzero(device.read(used))) - int(whole.sum(dtype=np.int64))


def _over(
    device: Device, kernel: str, triangles: Buffer, words: int, name: str, **arguments: Any
) -> NDArray[np.uint32]:
    """One launch over the triangles, and what each chunk says of itself."""
    count = triangles.shape[0]
    chunks = chunk_count(device, count)
    said = device.allocate(name, words * chunks, np.uint32)
    device.build(FILE).launch(
        f"hybrid_geometry_{kernel}", chunks, stage="join", local=chunk_local(device),
        triangles=triangles, triangle_count=count, chunk_count=chunks, **{name: said}, **arguments,
    )(Timeline())  # fmt: skip
    return device.read(said)
