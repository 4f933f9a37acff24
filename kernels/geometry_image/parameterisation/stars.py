"""Vertices on the sphere moved inside their stars so that the map stretches less; no triangle is ever turned over."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.geometry_image.parameterisation.hierarchy import Corners, Faces, Points

# exact in float32 too, in which kernels get their constants
INVERSE_STRETCH = 0.3125  # without it single sphere edges stay long and cut chords across the image
DOWNHILL_TRIALS, DOWNHILL_FACTOR, RANDOM_TRIALS = 6, 0.375, 4
LEAST_EDGE = 1e-4  # added to every squared edge, of their mean
STEP = 0.5  # of the star's root mean square radius


@dataclass(frozen=True)
class Stars:
    """The corners of some vertices, grouped by colour and then by vertex, with their triangles' rest shapes.

    ```
    vertices  (k,)    int64    in the order of colours; no two of a colour are neighbours
    colours   (c+1,)  int64    where each colour's vertices start
    starts    (k+1,)  int64    where each vertex's corners start
    after, last (s,)  int64    the corner's next and previous vertex in its triangle
    rest      (s, 4)  float64  area / 16, squared edges after-last, last-own, own-after; total area 4 pi
    ```
    """

    vertices: NDArray[np.int64]
    colours: NDArray[np.int64]
    starts: NDArray[np.int64]
    after: NDArray[np.int64]
    last: NDArray[np.int64]
    rest: Points

    @classmethod
    def of(cls, surface: Points, faces: Faces, vertices: NDArray[np.int64], seed: int) -> Stars:
        """The stars of `vertices` in a closed mesh of `faces` with its shape in space."""
        corners = Corners.of(faces, len(surface))
        colour = colouring(corners, vertices, seed)
        order = np.argsort(colour, kind="stable")
        vertices = vertices[order]
        counts = np.bincount(colour)
        starts = np.concatenate([[0], np.cumsum(corners.valence[vertices])])
        rows = np.repeat(corners.starts[vertices] - starts[:-1], np.diff(starts)) + np.arange(
            starts[-1]
        )
        after, last = corners.after[rows], corners.last[rows]
        shape = rest_shapes(surface, faces)
        face, k = corners.face[rows], corners.place[rows]
        rest = np.empty((len(after), 4))
        rest[:, 0] = shape[face, 3] / 16
        for side in range(3):  # edge j of a face lies opposite its corner j
            rest[:, side + 1] = shape[face, (k + side) % 3]
        return cls(vertices, np.concatenate([[0], np.cumsum(counts)]), starts, after, last, rest)


def rest_shapes(surface: Points, faces: Faces) -> Points:
    """Squared edges opposite the corners, and areas, of all triangles, scaled to a total area of 4 pi: (m, 4).

    All squared edges grow by a little: a triangle without area would weigh nothing and shrink to nothing, and no
    vertex could be put back inside it.
    """
    corner = [surface[faces[:, k]] for k in range(3)]
    squares = np.empty((len(faces), 4))
    for k in range(3):
        edge = corner[(k + 1) % 3] - corner[(k + 2) % 3]
        squares[:, k] = np.einsum("ij,ij->i", edge, edge)
    squares[:, :3] += LEAST_EDGE * squares[:, :3].mean()
    p, q, r = squares[:, :3].T
    squares[:, 3] = np.sqrt(np.maximum(4 * p * q - (p + q - r) ** 2, 1e-12 * p * q)) / 4
    return squares * (4 * np.pi / squares[:, 3].sum())


def colouring(corners: Corners, vertices: NDArray[np.int64], seed: int) -> NDArray[np.int64]:
    """A colour for each vertex such that no two neighbours share one; few colours, the same for the same seed.

    Source: Jones & Plassmann 1993: a vertex picks when its random number beats those of its undecided neighbours.
    """
    n = len(corners.valence)
    rank = np.zeros(n, np.int64)
    rank[vertices] = np.random.default_rng(seed).permutation(len(vertices)) + 1
    colour = np.full(n, -1)
    todo = vertices
    while len(todo):
        counts = corners.valence[todo]
        starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
        rows = np.repeat(corners.starts[todo] - starts, counts) + np.arange(counts.sum())
        neighbour = corners.after[rows]
        undecided = np.where(colour[neighbour] < 0, rank[neighbour], 0)
        picks = np.maximum.reduceat(undecided, starts) < rank[todo]
        bits = np.where(colour[neighbour] < 0, 0, 1 << np.maximum(colour[neighbour], 0))
        taken = np.bitwise_or.reduceat(bits, starts)[picks]
        free = ~taken & (taken + 1)
        colour[todo[picks]] = np.round(np.log2(free.astype(np.float64))).astype(np.int64)
        todo = todo[~picks]
    return colour[vertices]


def _dot(a: Points, b: Points) -> NDArray[np.float64]:
    return np.einsum("ij,ij->i", a, b)


def _cross(a: Points, b: Points) -> Points:
    result = np.empty_like(a)
    for k, (i, j) in enumerate(((1, 2), (2, 0), (0, 1))):
        result[:, k] = a[:, i] * b[:, j] - a[:, j] * b[:, i]
    return result


def corner_energies(
    a: Points, b: Points, c: Points, rest: Points, gradient: bool = False
) -> tuple[NDArray[np.float64], Points | None]:
    """Stretch of the sphere triangles (a, b, c) and, where asked for, its gradient by `a`; infinite where turned over.

    The energy is  [2 (4 A) (u.w l_bc - u.x l_ca + w.x l_ab) / M] / h + eps / (16 A) (|u|^2 (l_bc + l_ca - l_ab) + ...)
    with u = b - a, w = c - a, x = c - b, M = |u x w|^2, h = the flat triangle's distance from the centre.

    Source: Sander et al. 2001, section 3 (L2 stretch); the factor 1 / h, which keeps triangles off the great circles,
    and the inverse term are a reconstruction.
    """
    u, w = b - a, c - a
    x = w - u
    uw, ux, wx = _dot(u, w), _dot(u, x), _dot(w, x)
    uu, ww, xx = _dot(u, u), _dot(w, w), _dot(x, x)
    normal = _cross(u, w)
    m = _dot(normal, normal)
    det = _dot(a, normal)
    area, l_bc, l_ca, l_ab = (rest[:, k] for k in range(4))
    good = (det > 1e-300) & (m > 1e-40)
    m, det = np.where(good, m, 1.0), np.where(good, det, 1.0)
    h = det / np.sqrt(m)
    bracket = uw * l_bc - ux * l_ca + wx * l_ab
    q = 8 * area / m
    inverse = INVERSE_STRETCH / (256 * area)
    s_u, s_x, s_w = l_bc + l_ca - l_ab, l_ab + l_ca - l_bc, l_ab + l_bc - l_ca
    energy = np.where(good, q * bracket / h + inverse * (uu * s_u + xx * s_x + ww * s_w), np.inf)
    if not gradient:
        return energy, None
    turn = 2 * (uw[:, None] * (u + w) - u * ww[:, None] - w * uu[:, None])
    e = (q * bracket)[:, None]
    slope = (
        q[:, None] * (x * (l_ca - l_ab)[:, None] - (u + w) * l_bc[:, None])
        - e / m[:, None] * turn
        - e * (_cross(b, c) / det[:, None] - turn / (2 * m)[:, None])
    ) / h[:, None]
    slope -= 2 * inverse[:, None] * (u * s_u[:, None] + w * s_w[:, None])
    return energy, np.where(good[:, None], slope, 0.0)


def hashed_directions(vertices: NDArray[np.int64], turn: int) -> Points:
    """Three numbers from -1 to 1 per vertex and turn: the same on the host and on the device."""
    key = (vertices.astype(np.uint64) * 2654435761 + np.uint64(turn) * 40503) & 0xFFFFFFFF
    out = np.empty((len(vertices), 3))
    for k in range(3):
        key = (key + 0x9E3779B9) & 0xFFFFFFFF
        z = key
        for shift, factor in ((16, 0x21F0AAAD), (15, 0x735A2D97)):
            z = ((z ^ (z >> np.uint64(shift))) * factor) & 0xFFFFFFFF
        z = z ^ (z >> np.uint64(15))
        out[:, k] = z.astype(np.float64) / 2147483648.0 - 1.0
    return out


def _normalised(vectors: Points) -> Points:
    length = np.sqrt(_dot(vectors, vectors))
    return vectors / np.where(length > 0, length, 1)[:, None]


def sweep(sphere: Points, stars: Stars, turn: int, sweeps: int = 1) -> None:
    """Each vertex once a sweep, colour by colour: a downhill step and a random step, kept where the energy falls.

    Args:
        sphere: (n, 3) float64, unit length; changed in place.
        stars: whose vertices may move.
        turn: number of the first sweep, which the random directions depend on.
        sweeps: how many.
    """
    for k in range(sweeps):
        for first, end in zip(stars.colours[:-1], stars.colours[1:], strict=True):
            _move(sphere, stars, slice(int(first), int(end)), turn + k)


def _move(sphere: Points, stars: Stars, part: slice, turn: int) -> None:
    vertices = stars.vertices[part]
    begin = stars.starts[part]
    end = int(stars.starts[part.stop])
    rows = slice(int(begin[0]), end)
    valence = np.diff(stars.starts[part.start : part.stop + 1])
    starts = begin - begin[0]
    b, c, rest = sphere[stars.after[rows]], sphere[stars.last[rows]], stars.rest[rows]
    here = sphere[vertices]

    def energy(points: Points, gradient: bool = False):
        corner, slope = corner_energies(np.repeat(points, valence, 0), b, c, rest, gradient)
        total = np.add.reduceat(corner, starts)
        return total, None if slope is None else np.add.reduceat(slope, starts, axis=0)

    best, slope = energy(here, gradient=True)
    assert slope is not None
    spoke = b - np.repeat(here, valence, 0)
    radius = STEP * np.sqrt(np.add.reduceat(_dot(spoke, spoke), starts) / valence)

    def attempt(direction: Points, scales: list[float]) -> None:
        nonlocal here, best
        direction = _normalised(direction - here * _dot(direction, here)[:, None])
        origin = here
        for scale in scales:
            point = _normalised(origin + direction * (scale * radius)[:, None])
            value, _ = energy(point)
            better = value < best
            here = np.where(better[:, None], point, here)
            best = np.where(better, value, best)

    attempt(-slope, [DOWNHILL_FACTOR**k for k in range(DOWNHILL_TRIALS)])
    attempt(
        hashed_directions(vertices, turn),
        [(1 - 2 * (k % 2)) * 0.5 ** (k // 2) for k in range(RANDOM_TRIALS)],
    )
    sphere[vertices] = here
