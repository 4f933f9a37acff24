"""Edge collapse as one reads it: the whole mesh is one block, a list of edges is its queue, all in float64."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.edge_collapse.params import Params

RIDGE = TIE = 1e-6
"""Of the trace: what a sum of quadrics is solved with; and times the edge's length squared, what it costs more."""

LEVELLED, FOLDED = 0.5, 0.1
"""Of the volume, what is made up for; and the square of the share of the area that its normals must add up to."""

Real = NDArray[np.float64]
Edge = tuple[int, int]


@dataclass
class Quadric:
    """f(x) = (x - p) A (x - p) + 2 b (x - p) + c, weighted squares of distances from planes, about the vertex p."""

    p: Real
    A: Real = field(default_factory=lambda: np.zeros((3, 3)))
    b: Real = field(default_factory=lambda: np.zeros(3))
    c: float = 0.0

    def add(self, normal: Real, weight: float) -> None:
        """A plane through p, of that unit normal."""
        self.A += weight * np.outer(normal, normal)

    def about(self, p: Real) -> Quadric:
        """The same function, about another point."""
        d = p - self.p
        b = self.b + self.A @ d
        return Quadric(p, self.A, b, self.c + float(d @ (self.b + b)))


def merge(u: Quadric, v: Quadric) -> tuple[float, Quadric]:
    """What it costs to put two vertices where the sum of their quadrics is least, and the sum about that point."""
    middle, square = (u.p + v.p) / 2, float(((v.p - u.p) ** 2).sum())
    one, other = u.about(middle), v.about(middle)
    both = Quadric(middle, one.A + other.A, one.b + other.b, one.c + other.c)
    trace, step = float(np.trace(both.A)), np.zeros(3)
    if trace > 0:
        step = -np.linalg.solve(both.A + RIDGE * trace * np.eye(3), both.b)
        if (far := step @ step) > square:
            step *= np.sqrt(square / far)
    best = both.about(middle + step)
    best.c = max(best.c, 0.0)
    return best.c + TIE * trace * square, best


class Surface:
    """Triangles that change, with the quadrics of their vertices."""

    def __init__(self, mesh: TriangleMesh, params: Params) -> None:
        self.params = params
        low, high = mesh.box
        scale = 1 / max(float((high - low).max()), 1e-300)
        self.triangles = {
            number: list(map(int, row))
            for number, row in enumerate(mesh.triangles)
            if len(set(row)) == 3
        }
        self.at: dict[int, set[int]] = {}  # triangles of each vertex
        for number, row in self.triangles.items():
            for v in row:
                self.at.setdefault(v, set()).add(number)
        self.quadrics = {v: Quadric(mesh.positions[v] * np.float64(scale)) for v in self.at}
        self.parents: dict[int, int] = {}
        self.scale = scale
        for row in self.triangles.values():
            normal = self._normal(row)
            if (length := np.linalg.norm(normal)) > 0:
                for v in row:
                    self.quadrics[v].add(normal / length, length / 2)
        self.border = {v for v in self.at if self._ends(v)}
        for v in self.at:
            for w, row in self._ends(v) if v in self.border else []:
                self._hold(v, w, row)
            for w, *rows in self._creases(v):
                for row in rows:
                    self._hold(v, w, row)

    def _hold(self, v: int, w: int, row: list[int]) -> None:
        """A plane through an edge of the triangle, upright on it, for the first of its ends."""
        edge = self.quadrics[w].p - self.quadrics[v].p
        upright = np.cross(edge, self._normal(row))
        if (length := np.linalg.norm(upright)) > 0:
            self.quadrics[v].add(upright / length, self.params.border_weight * float(edge @ edge))

    def _creases(self, v: int) -> list[tuple[int, list[int], list[int]]]:
        """The neighbours of v over a crease, each with the two triangles there."""
        found = []
        for w in self.neighbours(v):
            rows = [self.triangles[t] for t in self.at[v] & self.at[w]]
            if len(rows) == 2:
                n, m = map(self._normal, rows)
                lengths = np.linalg.norm(n) * np.linalg.norm(m)
                if n @ m < self.params.crease_cosine * lengths:
                    found.append((w, *rows))
        return found

    def _normal(self, row: list[int]) -> Real:
        a, b, c = (self.quadrics[v].p for v in row)
        return np.cross(b - a, c - a)

    def _ends(self, v: int) -> list[tuple[int, list[int]]]:
        """The neighbours of v that one triangle alone has with it, and that triangle."""
        rows = [self.triangles[t] for t in self.at[v]]
        found = [(w, row) for row in rows for w in row if w != v]
        names = [w for w, _ in found]
        return [(w, row) for w, row in found if names.count(w) == 1]

    def neighbours(self, v: int) -> set[int]:
        return {w for t in self.at[v] for w in self.triangles[t]} - {v}

    def edges(self) -> Iterator[Edge]:
        """Each edge once, in the order in which triangles have them."""
        seen: set[frozenset[int]] = set()
        for row in self.triangles.values():
            for u, v in zip(row, row[1:] + row[:1], strict=True):
                if frozenset((u, v)) not in seen:
                    seen.add(frozenset((u, v)))
                    yield u, v

    def crowded(self, v: int) -> bool:
        """Has the vertex an edge of more than two triangles?"""
        return any(len(self.at[v] & self.at[w]) > 2 for w in self.neighbours(v))

    def keeps_surface(self, u: int, v: int) -> bool:
        """The link condition: is the surface of the same kind without the edge? Where it is no surface, are those near
        both ends just those opposite to the edge?
        """
        along = u in self.border and v in self.border
        expected = 1 if along else 2
        gone = self.at[u] & self.at[v]
        common = self.neighbours(u) & self.neighbours(v)
        unlike = len(gone) != expected or len(common) != expected
        if unlike or (along and any(len(self.at[w]) < 2 for w in common)):
            opposite = {w for t in gone for w in self.triangles[t]} - {u, v}
            return common == opposite and (self.crowded(u) or self.crowded(v))
        least = 1 if {u, v} & self.border else 3
        return len(self.at[u]) + len(self.at[v]) - 2 * expected >= least

    def levelled(self, u: int, v: int, merged: Quadric) -> Quadric:
        """The sum about a point at which the collapse changes the volume below the surface by half as much."""
        rows = [self.triangles[t] for t in self.at[u] | self.at[v]]
        normals = np.array([self._normal(row) for row in rows])
        above = np.array([self.quadrics[row[0]].p - merged.p for row in rows])
        normal, volume = normals.sum(axis=0), float((normals * above).sum())
        square, areas = float(normal @ normal), float(np.linalg.norm(normals, axis=1).sum())
        if not square > FOLDED * areas**2:
            return merged
        step = normal * (LEVELLED * volume / square)
        if not np.linalg.norm(step) < np.linalg.norm(self.quadrics[v].p - self.quadrics[u].p):
            return merged
        moved = merged.about(merged.p + step)
        moved.c = max(moved.c, 0.0)
        return moved

    def turns(self, u: int, v: int, p: Real) -> bool:
        """Would a triangle that stays turn by more than the limit?"""
        limit = np.cos(np.radians(self.params.normal_limit))
        for t in self.at[u] ^ self.at[v]:
            row = self.triangles[t]
            before = self._normal(row)
            if not before.any():
                continue
            a, b, c = (p if w in (u, v) else self.quadrics[w].p for w in row)
            after = np.cross(b - a, c - a)
            cosine = before @ after
            lengths = np.linalg.norm(before) * np.linalg.norm(after)
            if not (cosine > 0 and cosine >= limit * lengths):
                return True
        return False

    def collapse(self, u: int, v: int, merged: Quadric) -> int:
        """Vertex u goes to v; how many triangles went with it."""
        gone = self.at[u] & self.at[v]
        for t in gone:
            for w in self.triangles.pop(t):
                self.at[w].discard(t)
        for t in self.at.pop(u):
            self.triangles[t] = [v if w == u else w for w in self.triangles[t]]
            self.at[v].add(t)
        if u in self.border:
            self.border.add(v)
        self.quadrics[v] = merged
        self.parents[u] = v
        return len(gone)


def simplify(mesh: TriangleMesh, target: int, params: Params | None = None) -> TriangleMesh:
    """The cheapest edge first, until `target` triangles are left at most or no edge may go.

    Returns:
        The vertices in the input's order, float32 positions, and the triangles left, in the input's order.
    """
    surface = Surface(mesh, params or Params())
    number, queue = itertools.count(), []
    versions = dict.fromkeys(surface.at, 0)

    def ask(u: int, v: int) -> None:
        cost, _ = merge(surface.quadrics[u], surface.quadrics[v])
        heapq.heappush(queue, (cost, next(number), u, v, versions[u], versions[v]))

    kept = surface.border if surface.params.preserve_border else set[int]()
    for u, v in surface.edges():
        if not {u, v} & kept:
            ask(u, v)
    while queue and len(surface.triangles) > target:
        _, _, u, v, *asked = heapq.heappop(queue)
        if u not in surface.at or v not in surface.at or asked != [versions[u], versions[v]]:
            continue
        _, merged = merge(surface.quadrics[u], surface.quadrics[v])
        merged = surface.levelled(u, v, merged)
        if not surface.keeps_surface(u, v) or surface.turns(u, v, merged.p):
            continue
        surface.collapse(u, v, merged)
        versions[v] += 1
        for w in sorted(surface.neighbours(v) - kept):
            ask(v, w)
    used = sorted(v for v, rows in surface.at.items() if rows)
    numbers = {v: i for i, v in enumerate(used)}
    points = np.array([surface.quadrics[v].p / surface.scale for v in used]).reshape(-1, 3)
    rows = [[numbers[v] for v in row] for row in surface.triangles.values()]
    return TriangleMesh(points.astype(np.float32), np.array(rows, np.uint32).reshape(-1, 3))
