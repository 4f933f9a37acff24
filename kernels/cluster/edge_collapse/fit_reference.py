"""The fit of the last vertices to the input as one reads it, in float64."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.edge_collapse.fit import EVERY, FEW, MANY, SAMPLES

STEP, RIDGE, ROOM = 1.5, 1e-3, 0.45
ALIKE, FOLD, BENT = 1.0001, -0.5, 0.64
"""As in the kernels."""

Real = NDArray[np.float64]


def fit(
    mesh: TriangleMesh,
    result: TriangleMesh,
    vertex_map: NDArray[np.uint32],
    locked: NDArray[np.bool_],
    crease: float,
) -> Real:
    """Where the result's vertices lie then, (vertices, 3).

    Args:
        mesh: the input.
        result: what collapses left of it, triangles with area.
        vertex_map: (n,), the result's vertex of each one of the mesh.
        locked: (vertices,), those that stay.
        crease: cosine of the normals from which on edges are held.
    """
    places, triangles = result.positions.astype(np.float64), result.triangles
    wanted = min(SAMPLES * len(triangles), max(FEW * len(triangles), MANY))
    corners = mesh.triangles[:, [[0, 1, 2], [1, 2, 0], [2, 0, 1]]].reshape(-1, 3)
    corners = corners[:: 3 * mesh.triangle_count // wanted | 1]
    a, b, c = (mesh.positions[corners[:, k]].astype(np.float64) for k in range(3))
    samples, weights = (4 * a + b + c) / 6, np.linalg.norm(np.cross(b - a, c - a), axis=1)
    at: list[list[int]] = [[] for _ in places]
    for number, v in enumerate(vertex_map[corners[:, 0]]):
        if v < len(places):
            at[v].append(number)
    for every in EVERY:
        sums = _gather(places, triangles, samples, weights, [own[::every] for own in at])
        places = _move(places, triangles, sums, locked, crease)
    return places


def _normals(places: Real, triangles: NDArray[np.uint32]) -> Real:
    """Twice the area long."""
    a, b, c = (places[triangles[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def _gather(
    places: Real,
    triangles: NDArray[np.uint32],
    samples: Real,
    weights: Real,
    at: list[list[int]],
) -> Real:
    """What samples weigh for each triangle's corners, and that times their heights above it, (triangles, 3, 2)."""
    sums = np.zeros((len(triangles), 3, 2))
    normals = _normals(places, triangles)
    lengths = np.linalg.norm(normals, axis=1)
    for v, own in enumerate(at):
        rows, corners = np.nonzero(triangles == v)
        if len(rows) > 32:
            continue
        for sample in own:
            found = []
            for row, corner in zip(rows, corners, strict=True):
                ends = places[triangles[row]]
                unit = normals[row] / lengths[row]
                # the share of each corner is the height above the side opposite to it, of the corner's own
                sides = ends[[2, 0, 1]] - ends[[1, 2, 0]]
                past = ((samples[sample] - ends[[1, 2, 0]]) * np.cross(unit, sides)).sum(1)
                outside = max((-past / np.linalg.norm(sides, axis=1)).max(), 0.0)
                height = float(unit @ (samples[sample] - ends[0]))
                found.append((height**2 + outside**2, row, corner, past / lengths[row], height))
            nearest = min(square for square, *_ in found)
            for square, row, corner, shares, height in found:
                if square <= ALIKE * nearest and shares[corner] > 0:
                    shares = np.maximum(shares, 0) / np.maximum(shares, 0).sum()
                    sums[row] += weights[sample] * np.outer(shares, (1, height))
    return sums


def _move(
    places: Real,
    triangles: NDArray[np.uint32],
    sums: Real,
    locked: NDArray[np.bool_],
    crease: float,
) -> Real:
    """One step of all vertices at once."""
    normals = _normals(places, triangles)
    units = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    held = locked | _held(len(places), triangles, normals, crease)
    moved = places.copy()
    for v in np.flatnonzero(~held):
        rows, corners = np.nonzero(triangles == v)
        weight, high = sums[rows, corners].T
        if not weight.sum() > 0:
            continue
        square = np.einsum("i,ix,iy->xy", weight, units[rows], units[rows]) / weight.sum()
        step = np.linalg.solve(square + RIDGE * np.eye(3), high @ units[rows] / weight.sum())
        step *= STEP
        room = 1.0
        for row in rows:
            ends = places[triangles[row]]
            longest = np.linalg.norm(ends - ends[[1, 2, 0]], axis=1).max()
            flat = np.linalg.norm(step - (step @ units[row]) * units[row])
            if flat * room > (most := ROOM * np.linalg.norm(normals[row]) / longest):
                room = most / flat
        moved[v] += room * step
    return moved


def _held(
    count: int, triangles: NDArray[np.uint32], normals: Real, crease: float
) -> NDArray[np.bool_]:
    """Vertices on edges of one triangle or in creases; in folds where all normals add up to less than their sum."""
    lengths = np.linalg.norm(normals, axis=1)
    around, areas = np.zeros((count, 3)), np.zeros(count)
    for k in range(3):
        np.add.at(around, triangles[:, k], normals)
        np.add.at(areas, triangles[:, k], lengths)
    bent = (crease > FOLD + 1e-6) | ((around**2).sum(1) < BENT * areas**2)
    held, edges = np.zeros(count, bool), dict[tuple[int, int], list[int]]()
    for row, triangle in enumerate(triangles.tolist()):
        for k in range(3):
            u, v = triangle[k], triangle[(k + 1) % 3]
            edges.setdefault((min(u, v), max(u, v)), []).append(row)
    for ends, rows in edges.items():
        one, other = rows[0], rows[-1]
        if len(rows) == 1:
            held[list(ends)] = True
        elif normals[one] @ normals[other] < crease * lengths[one] * lengths[other]:
            held[list(ends)] |= bent[list(ends)]
    return held
