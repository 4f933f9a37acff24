"""Generated triangle meshes, from ten to ten million triangles: seeded, vectorised, no downloads."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh

_GOLDEN = (1 + 5**0.5) / 2
_ICOSAHEDRON = np.array(
    [
        (-1, _GOLDEN, 0), (1, _GOLDEN, 0), (-1, -_GOLDEN, 0), (1, -_GOLDEN, 0),
        (0, -1, _GOLDEN), (0, 1, _GOLDEN), (0, -1, -_GOLDEN), (0, 1, -_GOLDEN),
        (_GOLDEN, 0, -1), (_GOLDEN, 0, 1), (-_GOLDEN, 0, -1), (-_GOLDEN, 0, 1),
    ]
) / np.hypot(1, _GOLDEN)  # fmt: skip
_ICOSAHEDRON_FACES = np.array(
    [
        (0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11),
        (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
        (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9),
        (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1),
    ]
)  # fmt: skip


def _at_least(argument: str, value: int, least: int) -> None:
    if value < least:
        raise ValueError(f"{argument}: expected at least {least}, got {value}")


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _subdivided(positions: NDArray[np.float64], triangles: NDArray, passes: int):
    """Points (n, 3) and triangles after `passes` splits of each into four at its edges' midpoints.

    All points are pushed onto the unit sphere. The children of a triangle follow each other; the points of a
    pass follow the earlier ones, so corners that are close in space are far apart in memory.
    """
    triangles = triangles.astype(np.int64)
    for _ in range(passes):
        a, b, c = triangles.T
        start, end = np.concatenate([a, b, c]), np.concatenate([b, c, a])
        keys = np.minimum(start, end) * len(positions) + np.maximum(start, end)
        keys, middle = np.unique(keys, return_inverse=True)
        low, high = np.divmod(keys, len(positions))
        ab, bc, ca = (middle + len(positions)).reshape(3, -1)
        positions = np.concatenate([positions, _unit(positions[low] + positions[high])])
        triangles = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=1).reshape(-1, 3)
    return positions, triangles


def icosphere(level: int) -> TriangleMesh:
    """The unit sphere: an icosahedron subdivided `level` times, 20 * 4^level triangles, exact normals."""
    _at_least("level", level, 0)
    positions, triangles = _subdivided(_ICOSAHEDRON, _ICOSAHEDRON_FACES, level)
    return TriangleMesh(positions, triangles, positions)


def _geodesic(segments: int) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
    """The icosahedron with `segments` segments per edge, pushed onto the unit sphere, welded by index."""
    n, faces = segments, _ICOSAHEDRON_FACES
    row = np.repeat(np.arange(n + 1), np.arange(1, n + 2))
    column = np.arange(len(row)) - row * (row + 1) // 2
    weights = np.stack([n - row, row - column, column], axis=1)  # integers that sum to n

    # one number per point: 12 corners, then n - 1 per edge, then the inner points face by face
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
    edges, edge_of_side = np.unique(ends, axis=0, return_inverse=True)
    edge_of_side = edge_of_side.reshape(-1, 3)
    inner = np.flatnonzero((weights > 0).all(1))
    along = np.arange(1, n)
    first_inner = 12 + len(edges) * (n - 1)
    number = np.zeros((20, len(row)), np.uint32)
    positions = [_ICOSAHEDRON]
    p, q = _ICOSAHEDRON[edges[:, 0]], _ICOSAHEDRON[edges[:, 1]]
    t = along[None, :, None] / max(n, 1)
    positions.append(((1 - t) * p[:, None] + t * q[:, None]).reshape(-1, 3))
    for f in range(20):
        number[f, inner] = first_inner + f * len(inner) + np.arange(len(inner))
        for side in range(3):
            start, end = faces[f, side], faces[f, (side + 1) % 3]
            between = (weights[:, (side + 2) % 3] == 0) & (weights.max(1) < n)
            on_side = np.flatnonzero(between)
            toward_end = weights[on_side, (side + 1) % 3]
            step = toward_end if start < end else n - toward_end
            number[f, on_side] = 12 + edge_of_side[f, side] * (n - 1) + step - 1
        for corner in range(3):
            number[f, weights[:, corner] == n] = faces[f, corner]
        positions.append(weights[inner] / n @ _ICOSAHEDRON[faces[f]])

    up = np.flatnonzero(row < n)
    below = up + row[up] + 1
    down = np.flatnonzero((row < n) & (column < row))
    local = np.concatenate(
        [
            np.stack([up, below, below + 1], axis=1),
            np.stack([down, down + row[down] + 2, down + 1], axis=1),
        ]
    )
    local = local[np.argsort(np.concatenate([up * 2, down * 2 + 1]), kind="stable")]
    return _unit(np.concatenate(positions)), number[:, local].reshape(-1, 3)


def geodesic_sphere(segments: int) -> TriangleMesh:
    """The unit sphere with 20 * segments^2 triangles and exact normals, ordered face by face, row by row."""
    _at_least("segments", segments, 1)
    positions, triangles = _geodesic(segments)
    return TriangleMesh(positions, triangles, positions)


_WAVES = ((0.05, (8.0, 3.0, -2.0)), (0.02, (-13.0, 5.0, 21.0)))
"""Amplitude and wave vector of the two sines that `displaced_icosphere` adds to the radius."""


def displaced_icosphere(segments: int) -> TriangleMesh:
    """The sphere whose radius is 1 plus two sines of the direction: one surface, sampled at any size.

    20 * segments^2 triangles (256 gives 1,310,720), exact normals. With segments = odd * 2^level, the grid of
    `odd` segments is subdivided `level` times: the order is that of recursive subdivision, as other packages
    make it, and 256 has the triangles of `icosphere(8)`.
    """
    _at_least("segments", segments, 1)
    level = (segments & -segments).bit_length() - 1
    unit, triangles = _subdivided(*_geodesic(segments >> level), level)
    radius = np.ones(len(unit))
    slope = np.zeros_like(unit)
    for amplitude, wave in _WAVES:
        phase = unit @ wave
        radius += amplitude * np.sin(phase)
        slope += (amplitude * np.cos(phase))[:, None] * wave
    # the surface |p| = r(p / |p|): its gradient is the direction less the tangential slope over r
    slope -= np.einsum("ij,ij->i", slope, unit)[:, None] * unit
    normals = _unit(unit - slope / radius[:, None])
    return TriangleMesh(unit * radius[:, None], triangles, normals)


def sphere(triangles: int) -> TriangleMesh:
    """The unit sphere of slices and stacks with exactly `triangles` triangles and exact normals.

    Closed for every even count from 6 (a bipyramid: 10 has five slices and no ring but the equator).

    Raises:
        ValueError: an odd count or less than 6.
    """
    if triangles < 6 or triangles % 2:
        raise ValueError(f"triangles: expected an even number of at least 6, got {triangles}")
    half = triangles // 2
    divisors = [d for d in range(3, half + 1) if half % d == 0]
    slices = min(divisors, key=lambda d: abs(np.log(d / (2 * (half // d + 1)))))
    rings = half // slices
    polar = np.pi * np.arange(1, rings + 1) / (rings + 1)
    around = 2 * np.pi * np.arange(slices) / slices
    ring = np.stack(
        [
            np.outer(np.sin(polar), np.cos(around)),
            np.outer(np.sin(polar), np.sin(around)),
            np.outer(np.cos(polar), np.ones(slices)),
        ],
        axis=2,
    )
    positions = np.concatenate([[(0.0, 0.0, 1.0)], ring.reshape(-1, 3), [(0.0, 0.0, -1.0)]])
    return TriangleMesh(positions, revolved(slices, rings), positions)


def revolved(slices: int, rings: int) -> NDArray[np.int64]:
    """Triangles of a closed surface of revolution, (2 * slices * rings, 3): a pole, ring after ring, a pole."""
    i = np.arange(slices)
    j = (i + 1) % slices
    last = slices * rings + 1
    a = (1 + slices * np.arange(rings - 1)[:, None] + i).ravel()
    b = (1 + slices * np.arange(rings - 1)[:, None] + j).ravel()
    faces = [
        np.stack([np.zeros_like(i), 1 + i, 1 + j], axis=1),
        np.stack([a, a + slices, b + slices, a, b + slices, b], axis=1).reshape(-1, 3),
        np.stack([np.full_like(i, last), last - slices + j, last - slices + i], axis=1),
    ]
    return np.concatenate(faces)


def torus(around: int, across: int, radius: float = 1.0, tube: float = 0.35) -> TriangleMesh:
    """A closed torus about z with 2 * around * across triangles and exact normals."""
    _at_least("around", around, 3)
    _at_least("across", across, 3)
    u = 2 * np.pi * np.arange(around)[:, None] / around
    v = 2 * np.pi * np.arange(across)[None, :] / across
    normals = np.stack(
        [
            np.cos(u) * np.cos(v),
            np.sin(u) * np.cos(v),
            np.broadcast_to(np.sin(v), (around, across)),
        ],
        axis=2,
    ).reshape(-1, 3)
    ring = np.stack([np.cos(u), np.sin(u), 0 * u], axis=2)
    positions = (radius * ring).repeat(across, axis=1).reshape(-1, 3) + tube * normals
    i, j = np.arange(around)[:, None], np.arange(across)[None, :]
    k, m = (i + 1) % around, (j + 1) % across
    a, b, c, d = (
        x.ravel() for x in (i * across + j, k * across + j, k * across + m, i * across + m)
    )
    triangles = np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)
    return TriangleMesh(positions, triangles, normals)


def _grid(columns: int, rows: int) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
    """Points (n, 2) of the unit square, x fastest, and two triangles for each of its quads."""
    y, x = np.divmod(np.arange((columns + 1) * (rows + 1)), columns + 1)
    start = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    a, b = start, start + 1
    c, d = b + columns + 1, a + columns + 1
    triangles = np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3).astype(np.uint32)
    return np.stack([x / columns, y / rows], axis=1), triangles


def plane(columns: int, rows: int | None = None) -> TriangleMesh:
    """The flat unit square at z = 0, open, facing +z, 2 * columns * rows triangles, with uvs."""
    rows = columns if rows is None else rows
    _at_least("columns", columns, 1)
    _at_least("rows", rows, 1)
    uvs, triangles = _grid(columns, rows)
    positions = np.column_stack([uvs, np.zeros(len(uvs))])
    return TriangleMesh(positions, triangles, np.tile((0.0, 0.0, 1.0), (len(uvs), 1)), uvs)


def terrain(columns: int, seed: int = 0, octaves: int = 7, height: float = 0.25) -> TriangleMesh:
    """An open height field over the unit square, 2 * columns^2 triangles, with uvs and exact normals.

    A sum of octaves of smooth value noise on lattices of 4, 8, 16 ... cells, each half as high as the one
    before; the lattices depend on `seed` alone, so every size samples one surface.
    """
    _at_least("columns", columns, 1)
    uvs, triangles = _grid(columns, columns)
    side = columns + 1
    heights, slope_x, slope_y = (np.zeros((side, side)) for _ in range(3))
    random = np.random.default_rng(seed)
    for octave in range(octaves):
        cells = 4 << octave
        lattice = random.uniform(-1, 1, (cells + 1, cells + 1)) * height * 0.5 ** (octave + 1)
        place = np.arange(side) / columns * cells
        cell = np.minimum(place.astype(np.int64), cells - 1)
        t = place - cell
        fade = t**3 * (t * (6 * t - 15) + 10)
        steep = 30 * t**2 * (t - 1) ** 2 * cells  # d fade / d x
        across = np.diff(lattice, axis=1)[:, cell]
        along_x = lattice[:, cell] + fade * across
        step_y = np.diff(along_x, axis=0)[cell]
        heights += along_x[cell] + fade[:, None] * step_y
        slope_y += steep[:, None] * step_y
        across *= steep
        slope_x += across[cell] + fade[:, None] * np.diff(across, axis=0)[cell]
    normals = _unit(np.stack([-slope_x, -slope_y, np.ones_like(heights)], axis=2).reshape(-1, 3))
    return TriangleMesh(np.column_stack([uvs, heights.ravel()]), triangles, normals, uvs)
