"""How far the border of a surface is from the border of what was made of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh

MOST_EDGES = 30_000  # of either border: a soup has no border worth the time
MOST_POINTS = 4_000  # of each that are looked at
AT_ONCE = 2_000_000  # pairs of a point and an edge

Points = NDArray[np.float64]


def border_distance(reference: TriangleMesh, result: TriangleMesh) -> float | None:
    """The largest distance between two borders, edges of one triangle, either way; share of the reference's diagonal.

    It is looked at from ends and middles of edges, an even choice of 4,000 on each side. None where either has no
    border, or one of more than 30,000 edges.
    """
    one, other = (_edges(mesh, reference) for mesh in (reference, result))
    if not len(one) or not len(other) or max(len(one), len(other)) > MOST_EDGES:
        return None
    return max(_farthest(one, other), _farthest(other, one))


def _edges(mesh: TriangleMesh, reference: TriangleMesh) -> Points:
    """Both ends of each border edge, (k, 2, 3), in units of the reference's diagonal."""
    a, b, c = mesh.triangles.T
    t = mesh.triangles[(a != b) & (b != c) & (c != a)].astype(np.uint64)
    ends = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    keys = ends.min(1, initial=2**32) << np.uint64(32) | ends.max(1, initial=0)
    edges, uses = np.unique(keys, return_counts=True)
    rim = edges[uses == 1]
    rows = np.stack([rim >> np.uint64(32), rim & np.uint64(2**32 - 1)], 1).astype(np.int64)
    origins = [np.zeros(3) if m.origin is None else m.origin for m in (mesh, reference)]
    low = reference.box[0] + (origins[1] - origins[0])
    return (mesh.positions[rows].astype(np.float64) - low) / (reference.diagonal or 1.0)


def _farthest(edges: Points, others: Points) -> float:
    """The largest distance from points of some edges to the nearest of others."""
    points = np.concatenate([edges[:, 0], edges[:, 1], edges.mean(1)])
    points = points[:: -(-len(points) // MOST_POINTS)]
    start, along = others[:, 0], others[:, 1] - others[:, 0]
    square = np.maximum((along**2).sum(1), 1e-300)
    step, largest = max(AT_ONCE // len(others), 1), 0.0
    for first in range(0, len(points), step):
        off = points[first : first + step, None] - start
        share = np.clip((off * along).sum(-1) / square, 0, 1)
        nearest = ((off - share[..., None] * along) ** 2).sum(-1).min(1)
        largest = max(largest, float(np.sqrt(nearest.max())))
    return largest
