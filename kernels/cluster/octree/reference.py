"""Clustering on an octree in float64, written for reading; only the finest cell of a vertex is decided in float32."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.borders import NO_VERTICES, edges_of, used_once
from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.cluster.quadric_clustering.reference import NO_VERTEX, border_quadrics, place
from lodbench.kernels.cluster.unchanged import without_duplicates

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
RIDGES = (2e-4, 2e-3, 2e-2)  # of the solve, shares of the trace


def morton(steps: Integers) -> Integers:
    """The numbers of cells (n, 3) along the curve: bit k of x, y and z becomes bit 3 k, 3 k + 1 and 3 k + 2."""
    code = np.zeros(len(steps), np.int64)
    for bit in range(10):
        for axis in range(3):
            code |= ((steps[:, axis] >> bit) & 1) << (3 * bit + axis)
    return code


@dataclass(frozen=True)
class Tree:
    """Nodes of all levels, the finest first and the root last; each level's along the Morton curve.

    Attributes:
        leaves: node of the finest level of each vertex, (vertices,).
        parents: (n,); the root's is itself.
        starts: first node of each level, the root's level first.
        centres, edges: of the cells, in units of the finest cell edge, (n, 3) and (n,).
        A, b, c: summed quadrics about the centres, (n, 3, 3), (n, 3) and (n,).
        corners: sum of corners about the centres and their number, (n, 4).
        points: representatives in the same units, (n, 3).
        margins: how far each was from being placed otherwise, as a share of the limit that decided, (n,).
    """

    grid: Grid
    leaves: Integers
    parents: Integers
    starts: Integers
    centres: Floats
    edges: Floats
    A: Floats
    b: Floats
    c: Floats
    corners: Floats
    points: Floats
    margins: Floats


def moved(A: Floats, b: Floats, c: Floats, t: Floats) -> tuple[Floats, Floats]:
    """The vectors and constants of quadrics about origins that lie `t` before theirs: x becomes x - t."""
    At = np.einsum("nij,nj->ni", A, t)
    return b - At, c - 2 * np.einsum("ni,ni->n", b, t) + np.einsum("ni,ni->n", t, At)


def build(mesh: TriangleMesh, cells: float, levels: int | None = None, held: bool = False) -> Tree:
    """The tree whose finest grid has so many cells along the longest box edge.

    Args:
        mesh: what is simplified.
        cells: a real number; the last cells may be cut.
        levels: halvings down to these cells; None: no more than it takes.
        held: border edges add their planes.

    Source: DeCoro & Tatarchuk 2007, slides 12, 15 and 29-31.
    """
    grid = Grid.over(*mesh.box, cells)
    levels = levels or max((max(grid.counts) - 1).bit_length(), 1)
    points32 = grid.points(mesh.positions)
    steps = np.clip(
        (points32 * grid.per_axis).astype(np.int64), 0, np.array(grid.counts, np.int64) - 1
    )
    codes, leaves = np.unique(morton(steps), return_inverse=True)
    leaves = leaves.reshape(-1)

    # occupied cells of every level, from the finest to the root
    found, links = [codes], []
    for _ in range(levels):
        coarser, link = np.unique(found[-1] >> 3, return_inverse=True)
        found.append(coarser)
        links.append(link.reshape(-1))
    counts = np.array([len(level) for level in found])
    starts = np.concatenate([[0], np.cumsum(counts)])
    n = int(starts[-1])
    parents = np.concatenate(
        [link + start for link, start in zip(links, starts[1:-1], strict=True)]
        + [np.arange(starts[-2], n)]
    ).astype(np.int64)
    edges = np.repeat(2.0 ** np.arange(levels + 1), counts).astype(np.float64)
    codes = np.concatenate(found)
    at = np.stack(
        [sum(((codes >> (3 * bit + axis)) & 1) << bit for bit in range(10)) for axis in range(3)], 1
    )
    centres = (at + 0.5) * edges[:, None]

    # pass 1 about the centres of the finest cells
    points = points32.astype(np.float64)
    p = points[mesh.triangles].reshape(-1, 3, 3)
    m = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    length = np.linalg.norm(m, axis=1)
    normal, area = m / np.where(length > 0, length, 1)[:, None], length / 6
    A, b, c, corners = np.zeros((n, 3, 3)), np.zeros((n, 3)), np.zeros(n), np.zeros((n, 4))
    for k in range(3):
        node = leaves[mesh.triangles[:, k]] if len(mesh.triangles) else np.zeros(0, np.int64)
        local = p[:, k] - centres[node]
        d = -np.einsum("ni,ni->n", normal, local)
        np.add.at(A, node, area[:, None, None] * normal[:, :, None] * normal[:, None, :])
        np.add.at(b, node, (area * d)[:, None] * normal)
        np.add.at(c, node, area * d * d)
        np.add.at(corners, node, np.concatenate([local, np.ones((len(node), 1))], 1))

    if held:
        border = used_once(edges_of(mesh.triangles), mesh.positions)
        own_A, _ = border_quadrics(points, border)
        for end in (0, 1):
            # planes through this end: about the centre b = -A t and c = t A t
            node = leaves[border[:, end]]
            t = points[border[:, end]] - centres[node]
            b_own = -np.einsum("nij,nj->ni", own_A, t)
            np.add.at(A, node, own_A)
            np.add.at(b, node, b_own)
            np.add.at(c, node, -np.einsum("ni,ni->n", b_own, t))

    # every parent is the sum of its children
    for level in range(levels):
        rows = np.arange(starts[level], starts[level + 1])
        up = parents[rows]
        t = centres[rows] - centres[up]
        b_up, c_up = moved(A[rows], b[rows], c[rows], t)
        np.add.at(A, up, A[rows])
        np.add.at(b, up, b_up)
        np.add.at(c, up, c_up)
        np.add.at(corners[:, :3], up, corners[rows, :3] + corners[rows, 3:] * t)
        np.add.at(corners[:, 3], up, corners[rows, 3])

    # pass 2, in units of each node's own edge, so that a step may be as long as its cell
    means = corners[:, :3] / np.maximum(corners[:, 3:], 1)
    b_mean = np.einsum("nij,nj->ni", A, means) + b
    step, _, margins = place(A, b_mean / edges[:, None], "robust", 1.0, ridges=RIDGES)
    return Tree(
        grid, leaves, parents, starts[:-1][::-1], centres, edges, A, b, c, corners,
        centres + means + step * edges[:, None], margins,
    )  # fmt: skip


def energies(A: Floats, b: Floats, c: Floats, x: Floats) -> Floats:
    """The quadrics at points about their origins, (n,)."""
    found = np.einsum("ni,nij,nj->n", x, A, x) + 2 * np.einsum("ni,ni->n", b, x) + c
    return np.maximum(found, 0)


def errors(tree: Tree, mesh: TriangleMesh, rule: str) -> Floats:
    """Of each node, (n,): a length in units of the finest cell edge; "total" is not divided by the mesh's area yet."""
    if rule == "maximum":
        found = np.zeros(len(tree.parents))
        p = tree.grid.points(mesh.positions).astype(np.float64)[mesh.triangles].reshape(-1, 3, 3)
        m = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
        length = np.linalg.norm(m, axis=1)
        flat = length**2 <= 1e-30
        normal = m / np.where(flat, 1, length)[:, None]
        for k in range(3):
            node = tree.leaves[mesh.triangles[~flat, k]]
            for _ in tree.starts:
                far = np.abs(np.einsum("ni,ni->n", normal[~flat], tree.points[node] - p[~flat, 0]))
                np.maximum.at(found, node, far)
                node = tree.parents[node]
    else:
        energy = energies(tree.A, tree.b, tree.c, tree.points - tree.centres)
        if rule == "rms":
            energy /= np.maximum(np.trace(tree.A, axis1=1, axis2=2), 1e-30)
        found = np.sqrt(energy)
    return found


def emit(
    tree: Tree,
    mesh: TriangleMesh,
    nodes: Integers,
    points: Floats | None = None,
    kept: NDArray[np.integer] = NO_VERTICES,
    distinct: bool = False,
) -> tuple[TriangleMesh, Integers, NDArray[np.uint32]]:
    """The mesh that is left where vertices go to `nodes`, the node of each of its vertices, and the map to them.

    Args:
        tree: whose nodes they are.
        mesh: what is simplified.
        nodes: of each vertex, (vertices,).
        points: representatives, in units of the finest cell edge; None: the tree's own.
        kept: vertices that stay by themselves, ascending; they come last.
        distinct: keep the first of triangles with the same three vertices.
    """
    nodes, count = nodes.copy(), len(tree.parents)
    nodes[kept] = count + np.arange(len(kept))
    corners = nodes[mesh.triangles].reshape(-1, 3)
    a, b, c = corners.T
    used, triangles = np.unique(
        corners[(a != b) & (b != c) & (c != a)].astype(np.int64), return_inverse=True
    )
    new = np.full(count + len(kept), NO_VERTEX)
    new[used] = np.arange(len(used))
    points = tree.points if points is None else points
    own = used[used < count]
    positions = np.concatenate(
        [tree.grid.positions(points[own]), mesh.positions[kept[used[len(own) :] - count]]]
    )
    left = TriangleMesh(positions, triangles.reshape(-1, 3))
    return without_duplicates(left) if distinct else left, used, new[nodes]
