"""A closed genus-0 mesh taken apart vertex by vertex down to a tetrahedron, remembering how to put it back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
Faces = NDArray[np.int64]

MAX_VALENCE = 7  # of a vertex that is removed; a genus-0 mesh always has one of at most 5
BASE = 4
ONE_BY_ONE = 64  # below this many vertices only the cheapest one goes
FLIP_COSINE = 0.2


@dataclass(frozen=True)
class Level:
    """One batch of half-edge collapses, and the mesh before it.

    ```
    removed  (k,)    int64   vertices; no two are neighbours
    rings    (k, K)  int64   their neighbours, counter-clockwise, the collapse's target first; -1 past the valence
    valence  (k,)    int64
    faces    (m, 3)  int64   all triangles before the collapse
    ```
    """

    removed: NDArray[np.int64]
    rings: Faces
    valence: NDArray[np.int64]
    faces: Faces


@dataclass
class Corners:
    """The three corners of each face, sorted by vertex: `v` is followed by `after`, then by `last`, in its face."""

    starts: NDArray[np.int64]
    after: NDArray[np.int64]
    last: NDArray[np.int64]
    face: NDArray[np.int64]
    place: NDArray[np.int64]  # of the corner in its face, 0 to 2
    valence: NDArray[np.int64]

    @classmethod
    def of(cls, faces: Faces, vertex_count: int) -> Corners:
        vertex = faces.ravel()
        order = np.argsort(vertex, kind="stable")
        valence = np.bincount(vertex, minlength=vertex_count)
        starts = np.concatenate([[0], np.cumsum(valence)])
        after = np.roll(faces, -1, axis=1).ravel()[order]
        last = np.roll(faces, 1, axis=1).ravel()[order]
        return cls(starts, after, last, order // 3, order % 3, valence)

    def rings(self, vertices: NDArray[np.int64], valence: int) -> Faces:
        """Neighbours of vertices of one valence, counter-clockwise, (len(vertices), valence)."""
        rows = self.starts[vertices][:, None] + np.arange(valence)
        after, last = self.after[rows], self.last[rows]
        ring = np.empty_like(after)
        ring[:, 0] = after[:, 0]
        ring[:, 1] = current = last[:, 0]
        row = np.arange(len(vertices))
        for k in range(2, valence):
            current = last[row, np.argmax(after == current[:, None], axis=1)]
            ring[:, k] = current
        return ring


def plane_quadrics(positions: Points, faces: Faces) -> Points:
    """Per vertex, the area-weighted sum of its planes' quadrics: (n, 10), upper triangle by rows.

    Source: Garland & Heckbert 1997, section 5.
    """
    a, b, c = (positions[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    unit = normal / np.where(length > 0, length, 1)[:, None]
    plane = np.concatenate([unit, -np.einsum("ij,ij->i", unit, a)[:, None]], axis=1)
    i, j = np.triu_indices(4)
    terms: Points = plane[:, i] * plane[:, j] * (length / 2)[:, None]
    vertex = faces.ravel()
    sums = [np.bincount(vertex, np.repeat(terms[:, k], 3), len(positions)) for k in range(10)]
    return np.stack(sums, axis=1).astype(np.float64)


def _quadric_at(quadrics: Points, points: Points) -> NDArray[np.float64]:
    x, y, z = (points[..., k] for k in range(3))
    q = [quadrics[..., k] for k in range(10)]
    return (
        x * (q[0] * x + 2 * (q[1] * y + q[2] * z + q[3]))
        + y * (q[4] * y + 2 * (q[5] * z + q[6]))
        + z * (q[7] * z + 2 * q[8])
        + q[9]
    )


class _Edges:
    """Does an edge exist? A table of hashes answers most questions, the sorted keys the rest."""

    def __init__(self, corners: Corners, span: int) -> None:
        self._span = span
        start = np.repeat(np.arange(len(corners.valence)), corners.valence)
        self._keys = np.sort(start * span + corners.after)
        self._bits = len(self._keys).bit_length() + 4  # about one false alarm in twenty
        self._seen = np.zeros(1 << self._bits, bool)
        self._seen[self._hash(self._keys)] = True

    def _hash(self, keys: NDArray[np.int64]) -> NDArray[np.uint64]:
        return (keys.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)) >> np.uint64(
            64 - self._bits
        )

    def exist(self, a: NDArray[np.int64], b: NDArray[np.int64]) -> NDArray[np.bool_]:
        keys = a * self._span + b
        found = self._seen[self._hash(keys)]
        asked = keys[found]
        at = np.minimum(np.searchsorted(self._keys, asked), len(self._keys) - 1)
        found[found] = self._keys[at] == asked
        return found


def _unit(vectors: Points) -> Points:
    length = np.sqrt(np.einsum("...i,...i->...", vectors, vectors))[..., None]
    return vectors / np.where(length > 0, length, 1)


def _cross(a: Points, b: Points) -> Points:
    """As numpy.cross, several times faster: no axis juggling."""
    result = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for k, (i, j) in enumerate(((1, 2), (2, 0), (0, 1))):
        np.multiply(a[..., i], b[..., j], out=result[..., k])
        result[..., k] -= a[..., j] * b[..., i]
    return result


def _square(vectors: Points) -> NDArray[np.float64]:
    return np.einsum("...i,...i->...", vectors, vectors)


def _best_targets(
    vertices: NDArray[np.int64],
    rings: Faces,
    positions: Points,
    quadrics: Points,
    valence: NDArray[np.int64],
    edges: _Edges,
    alive: int,
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Cheapest allowed collapse of each vertex: its cost (infinite: none) and the target's place in the ring."""
    d = rings.shape[1]
    around, here = positions[rings], positions[vertices]
    spoke = around - here[:, None]
    spoke_square = _square(spoke)
    rim_square = _square(np.roll(around, -1, axis=1) - around)
    old = _unit(_cross(spoke, np.roll(spoke, -1, axis=1)))
    cost = np.empty((len(vertices), d))
    for s in range(d):
        turn = (s + np.arange(d)) % d
        target, others = rings[:, s], rings[:, turn[2 : d - 1]]
        out = around[:, turn[1:]] - around[:, s : s + 1]
        out_square = _square(out)
        normal = _cross(out[:, :-1], out[:, 1:])
        double_area = np.sqrt(_square(normal))
        safe = np.maximum(double_area, 1e-300)
        aspect = (out_square[:, :-1] + out_square[:, 1:] + rim_square[:, turn[1 : d - 1]]) / (
            3.46 * safe
        )
        cosine = np.einsum("mki,mki->mk", normal, old[:, turn[1 : d - 1]]) / safe
        length_square = spoke_square[:, s]
        c = _quadric_at(quadrics[vertices] + quadrics[target], around[:, s])
        c = np.maximum(c, 0) + 1e-9 * length_square
        c *= 1 + 0.1 * np.minimum(1e4, aspect.max(axis=1))
        c = np.where(cosine.min(axis=1) < FLIP_COSINE, 1e3 * c + 1e-3 * length_square, c)
        over = np.maximum(valence[target] + d - 4 - MAX_VALENCE, 0)
        c *= (1.0 + over) ** 2
        if d > 3:
            taken = edges.exist(np.repeat(target, d - 3), others.ravel()).reshape(-1, d - 3)
            c[taken.any(axis=1)] = np.inf
        elif alive <= BASE:
            c[:] = np.inf
        cost[:, s] = c
    best = np.argmin(cost, axis=1)
    return cost[np.arange(len(best)), best], best


def _independent(
    vertices: NDArray[np.int64],
    cost: NDArray[np.float64],
    rings: Faces,
    valence: NDArray[np.int64],
    span: int,
    rng: np.random.Generator,
) -> NDArray[np.int64]:
    """Rows that collapse together: no two neighbours, no two that would make the same edge."""
    rows = np.argsort(cost, kind="stable")[: max(len(cost) // 2, 1)]
    rows = rows[np.isfinite(cost[rows])]
    noisy = np.log(cost[rows] + 1e-300) + rng.normal(0, 1, len(rows))
    priority = np.full(span + 1, np.inf)  # the last entry is the ring's padding
    priority[vertices[rows][np.argsort(noisy, kind="stable")]] = np.arange(len(rows))
    rows = rows[priority[vertices[rows]] < priority[rings[rows]].min(axis=1)]
    while len(rows):
        ring = rings[rows]
        k = np.arange(2, ring.shape[1])
        made = k < valence[rows][:, None] - 1
        a, b = np.broadcast_to(ring[:, :1], made.shape)[made], ring[:, 2:][made]
        owner = np.nonzero(made)[0]
        key = np.minimum(a, b) * span + np.maximum(a, b)
        order = np.lexsort((priority[vertices[rows[owner]]], key))
        again = np.zeros(len(key), bool)
        again[order[1:]] = key[order[1:]] == key[order[:-1]]
        if not again.any():
            break
        rows = np.delete(rows, np.unique(owner[again]))
    return rows


def take_apart(
    positions: Points,
    faces: Faces,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> tuple[list[Level], Faces]:
    """Half-edge collapses in independent batches down to four vertices: the levels, fine to coarse, and the base.

    Args:
        positions: (n, 3) float64, total area about 4 pi.
        faces: (m, 3) int64, closed, oriented, genus 0.
        seed: of the noise that spreads a batch over the surface.
        progress: called with the share done, 0 to 1.

    Raises:
        RuntimeError: no collapse is allowed; on a genus-0 manifold this does not happen.

    Source: Hoppe 1996 (progressive meshes, half-edge collapses in reverse order are vertex splits) and Praun & Hoppe
    2003, section 4; the batches, the costs and their constants are a reconstruction.
    """
    n = len(positions)
    rng = np.random.default_rng(seed)
    quadrics = plane_quadrics(positions, faces)
    levels: list[Level] = []
    alive = n
    while alive > BASE:
        corners = Corners.of(faces, n)
        edges = _Edges(corners, n)
        parts = []
        for d in range(3, MAX_VALENCE + 1):
            vertices = np.flatnonzero(corners.valence == d)
            if not len(vertices):
                continue
            ring = corners.rings(vertices, d)
            cost, best = _best_targets(
                vertices, ring, positions, quadrics, corners.valence, edges, alive
            )
            turned = np.full((len(vertices), MAX_VALENCE), -1)
            turned[:, :d] = np.take_along_axis(ring, (best[:, None] + np.arange(d)) % d, axis=1)
            parts.append((vertices, cost, turned))
        vertices, cost, rings = (np.concatenate(part) for part in zip(*parts, strict=True))
        if not np.isfinite(cost).any():
            raise RuntimeError(f"no collapse is possible with {alive} vertices left")
        if alive <= ONE_BY_ONE:
            rows = np.array([np.argmin(cost)])
        else:
            rows = _independent(vertices, cost, rings, corners.valence[vertices], n, rng)
        removed, ring, valence = vertices[rows], rings[rows], corners.valence[vertices[rows]]
        levels.append(Level(removed, ring, valence, faces))
        np.add.at(quadrics, ring[:, 0], quadrics[removed])
        gone = np.zeros(n, bool)
        gone[removed] = True
        k = np.arange(1, MAX_VALENCE - 1)
        made = k < valence[:, None] - 1
        fans = np.stack(
            [
                np.broadcast_to(ring[:, :1], made.shape)[made],
                ring[:, 1:-1][made],
                ring[:, 2:][made],
            ],
            axis=1,
        )
        faces = np.concatenate([faces[~gone[faces].any(axis=1)], fans])
        alive -= len(removed)
        if progress is not None:
            progress(1 - alive / n)
    return levels, faces
