"""A mesh with its collapses in a valid order: any level of detail between can be had afterwards.

Source: Hoppe, Progressive Meshes, SIGGRAPH 96, whose sequence this is; he keeps it to be run backwards.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Floats, Indices, TriangleMesh
from lodbench.kernels.cluster.edge_collapse.host import EdgeCollapse
from lodbench.kernels.cluster.edge_collapse.params import Params
from lodbench.kernels.cluster.edge_collapse.prepare import prepare
from lodbench.kernels.opencl import Device
from lodbench.kernels.parameters import Range, check
from lodbench.kernels.system import run

LARGEST = np.float32(3.4e38)


@dataclass(frozen=True, eq=False)
class Collapses:
    """Collapses in the order of sweeps, and of costs in each of them.

    Attributes:
        mesh: what was simplified, positions and triangles alone.
        gone: (k,) uint32, the vertex that went.
        kept: (k,) uint32, the vertex that it went to.
        places: (k, 3) float32, where that one lies since then, model units.
        triangles: (k,) int64, how many are left then.
        fitted: float32, the vertices after the last collapse where they were fitted to the input then, (vertices, 3);
            places are those of the collapses themselves. None where they were not.
    """

    mesh: TriangleMesh
    gone: NDArray[np.uint32]
    kept: NDArray[np.uint32]
    places: Floats
    triangles: NDArray[np.int64]
    fitted: Floats | None = None


def collapses(device: Device, mesh: TriangleMesh, **options: Any) -> Collapses:
    """The collapses from a mesh to the target, options being those of `Params`."""
    given = mesh.bare()
    prepared = prepare(device, given, Params.named(**options), recorded=True)
    run(device, prepared)
    if not isinstance(prepared, EdgeCollapse):
        none = np.zeros(0, np.uint32)
        return Collapses(given, none, none, np.zeros((0, 3), np.float32), np.zeros(0, np.int64))
    parents, keys, moves = device.read_all(
        (prepared.parents, None), (prepared.sequence, None), (prepared.moves, None)
    )
    gone = np.flatnonzero(parents != np.arange(len(parents), dtype=np.uint32))
    gone = gone[np.lexsort(keys[gone].T[::-1])]
    places = np.clip(moves[gone, :3] * np.float32(prepared.unscale), -LARGEST, LARGEST)
    left = len(_whole(given.triangles)) - np.cumsum(moves[gone, 3].astype(np.int64))
    fitted = prepared.result()[0].positions if prepared.fit is not None else None
    return Collapses(given, gone.astype(np.uint32), parents[gone], places, left, fitted)


def replay(made: Collapses, count: int) -> TriangleMesh:
    """The mesh of at most `count` triangles, or as few as there are at the end of the collapses.

    Where vertices are fitted to the input (`fit` of the Params) that is so of the last level alone, which is then what
    `simplify` gives; those before it are as collapses left them.

    Vertices are numbered in the input's order, triangles are in it too; those that name a vertex twice are left out.

    Raises:
        TypeError, ValueError: `count` is no whole number of at least 1.
    """
    check("count", count, int)
    if count not in Range(1):
        raise ValueError(f"count: expected {Range(1)}, got {count}")
    mesh = made.mesh
    there = len(_whole(mesh.triangles)) <= count
    done = 0 if there else int(np.searchsorted(-made.triangles, -count)) + 1
    done = min(done, len(made.gone))
    root = np.arange(mesh.vertex_count, dtype=np.uint32)
    root[made.gone[:done]] = made.kept[:done]
    while not np.array_equal(above := root[root], root):
        root = above
    # the last of a vertex's moves is the one that counts
    kept, latest = np.unique(made.kept[:done][::-1], return_index=True)
    positions = mesh.positions.copy()
    positions[kept] = made.places[:done][::-1][latest]
    rows = _whole(root[_whole(mesh.triangles)].reshape(-1, 3))
    used, triangles = np.unique(rows, return_inverse=True)
    triangles = triangles.reshape(-1, 3).astype(np.uint32)
    last = made.fitted if done == len(made.gone) > 0 else None
    return replace(mesh, positions=positions[used] if last is None else last, triangles=triangles)


def _whole(triangles: Indices) -> Indices:
    """Those of three different vertices."""
    a, b, c = triangles.T
    return triangles[(a != b) & (b != c) & (c != a)]
