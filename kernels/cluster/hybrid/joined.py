"""A clustered mesh that is the surface it was: cells that would change it are taken apart into their vertices.

Each vertex has a label, its cell's output vertex. Where the triangles around one are not one fan, the cell has joined
what must stay apart: its vertices get labels of their own, and so do those of cells that no triangle uses, until every
cell that is left is one fan. What comes out is closed where the input is, and manifold; what a cell can still hide,
a handle within it, changes the number of vertices - edges + triangles, which is compared.

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
ROUNDS = 30  # each takes some cells apart; two or three are the rule


@dataclass(frozen=True)
class Joined:
    """A mesh of cells and of single vertices.

    Attributes:
        mesh: positions and triangles; every vertex is used.
        vertex_map: (n,) its vertex of each input vertex, 0xFFFFFFFF where no triangle has it.
        sources: (m,) the input triangle of each triangle, ascending.
        singles: vertices that stay by themselves.
        surface: around every vertex is one fan.
    """

    mesh: TriangleMesh
    vertex_map: NDArray[np.uint32]
    sources: NDArray[np.uint32]
    singles: int
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
    single = vertex_map == NO_VERTEX
    if locked is not None:
        single |= locked
    left, rows = clustered.triangles, None
    bad = troubled(device, left, cells) if locked is None else np.zeros(cells, bool)
    own = np.flatnonzero(single)
    surface = not bad.any()
    for _ in range(ROUNDS):
        if bad.any():
            single |= np.append(bad, False)[np.minimum(vertex_map, np.uint32(cells))]
            own = np.flatnonzero(single)
        labels = vertex_map.copy()
        labels[own] = cells + np.arange(len(own), dtype=np.uint32)
        left, rows = _join(device, triangles, labels)
        found = _troubled_near(device, left, cells, cells + len(own))
        bad, surface = found[:cells], not found.any()
        if not bad.any():
            break
    assert rows is not None
    places = np.concatenate([clustered.positions, positions[own]])
    used = np.zeros(len(places) + 1, bool)
    used[left.reshape(-1)] = True
    numbers = np.where(used, np.cumsum(used) - 1, NO_VERTEX).astype(np.uint32)
    mesh = TriangleMesh.of_kernels(places[used[:-1]], numbers[left])
    return Joined(mesh, numbers[labels], rows, len(own), surface)


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
