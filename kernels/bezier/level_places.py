"""What is known of patches with a level each: their edges' levels, where their vertices stand, and were they right?"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lodbench.datasets_gen.surfaces import BezierPatches, Floats, TriangleMesh
from lodbench.kernels.bezier import borders
from lodbench.kernels.bezier.arrangement import Arrangement
from lodbench.kernels.bezier.reference import Doubles, normals_at, points_at
from lodbench.kernels.bezier.tessellated import CHECKED
from lodbench.kernels.exactness import verdict
from lodbench.kernels.system import Check


def edge_levels(found: borders.Borders, levels: borders.Numbers) -> borders.Numbers:
    """Of every edge, (m, 4), from its patches' levels, (m,): that of the coarsest that has it."""
    least = np.full(int(found.curve.max(initial=-1)) + 1, 1 << 30)
    np.minimum.at(least, found.curve, np.broadcast_to(levels[:, None], found.curve.shape))
    return least[found.curve]


def border_places(arrangements: Sequence[Arrangement]) -> list[borders.Numbers]:
    """Of each level the vertices on a patch's border: slot, i and j, (k, 3)."""
    found = []
    for level, one in enumerate(arrangements):
        n = 1 << level
        i, j = np.divmod(one.places, n + 1)
        slots = np.flatnonzero((i == 0) | (i == n) | (j == 0) | (j == n))
        found.append(np.stack([slots, i[slots], j[slots]], axis=1))
    return found


def snapped_vertices(
    arrangements: Sequence[Arrangement], levels: borders.Numbers, edges: borders.Numbers
) -> tuple[borders.Numbers, borders.Numbers, borders.Numbers]:
    """Of every vertex its patch and where it stands, i and j on the finest lattice, (n,) each.

    Args:
        arrangements: by level; the last one's is the finest.
        levels: of the patches, (m,).
        edges: levels of their edges, (m, 4).
    """
    finest, parts = len(arrangements) - 1, []
    for patch, (level, own) in enumerate(zip(levels, edges, strict=True)):
        n = 1 << int(level)
        i, j = np.divmod(arrangements[level].places, n + 1)
        at = np.stack([i, j], axis=1)
        for edge in range(4):
            axis, end = divmod(edge, 2)
            on = (at[:, axis] == end * n) & ~((axis == 1) & ((i == 0) | (i == n)))
            drop = int(level - own[edge])
            at[on, 1 - axis] = at[on, 1 - axis] >> drop << drop
        parts.append(np.column_stack([np.full(len(at), patch), at << int(finest - level)]))
    found = np.concatenate([np.zeros((0, 3), np.int64), *parts])
    return found[:, 0], found[:, 1], found[:, 2]


def judged(
    patches: BezierPatches,
    finest: int,
    mesh: TriangleMesh,
    patch: borders.Numbers,
    i: borders.Numbers,
    j: borders.Numbers,
) -> Check:
    """Were these the patches' points and normals? Some patches, spread over all, are compared with float64."""
    count = len(patches.points)
    chosen = np.unique(np.linspace(0, max(count - 1, 0), min(CHECKED, count)).astype(np.int64))
    box = patches.points.reshape(-1, 3).astype(np.float64)
    size = np.linalg.norm(np.ptp(box, axis=0)) if len(box) else 1.0
    size = max(float(size), float(np.abs(box).max(initial=0)), 1e-37)
    position = turned = 0.0
    for p in chosen:
        rows = np.flatnonzero(patch == p)
        P = patches.points[p : p + 1].astype(np.float64)
        u, v = (values[rows] / (1 << finest) for values in (i, j))
        off = np.abs(mesh.positions[rows] - points_at(P, u, v)[0]).max(initial=0)
        position = float(np.max([position, off / size]))  # NaN is worst
        if mesh.normals is not None:
            turned = float(np.max([turned, _turned(P, u, v, mesh.normals[rows])]))
    return verdict(position, turned, f"{len(chosen)} of {count} patches")


def _turned(P: Doubles, u: Doubles, v: Doubles, normals: Floats) -> float:
    expected, certain = normals_at(P, u, v)
    return float(np.linalg.norm(normals - expected[0], axis=-1)[certain[0]].max(initial=0))
