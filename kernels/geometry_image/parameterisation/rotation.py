"""How the sphere is turned before it is unfolded: a few rotations tried, the one with the smallest error kept."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.geometry_image.parameterisation import octahedron
from lodbench.kernels.geometry_image.parameterisation.hierarchy import Faces, Points
from lodbench.kernels.geometry_image.parameterisation.locate import Locator

METHOD = 1  # part of the cache's key: another number for another way of choosing
COUNT = 24
TRIAL_LEVEL = 6
SAMPLES = 4000
REACH = 1  # image cells around a sample's own in which its nearest triangle is looked for


def candidates(count: int = COUNT, seed: int = 0) -> Points:
    """Rotation matrices spread at random, identity first: (count, 3, 3).

    Source: Shoemake 1992 (uniform random quaternions).
    """
    q = np.random.default_rng(seed).normal(size=(count, 4))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    q[0] = (1, 0, 0, 0)
    w, x, y, z = q.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows).transpose(2, 0, 1)


def squared_distances(points: Points, a: Points, b: Points, c: Points) -> NDArray[np.float64]:
    """From points to triangles, (..., 3) each, broadcast.

    Source: Ericson 2005, section 5.1.5, with the seven regions as clamps.
    """
    ab, ac, ap = b - a, c - a, points - a
    dot = lambda p, q: np.einsum("...i,...i->...", p, q)  # noqa: E731 - one word for eight uses
    d00, d01, d11 = dot(ab, ab), dot(ab, ac), dot(ac, ac)
    d20, d21 = dot(ap, ab), dot(ap, ac)
    scale = d00 * d11 - d01 * d01
    safe = np.where(scale > 0, scale, 1)
    v, w = (d11 * d20 - d01 * d21) / safe, (d00 * d21 - d01 * d20) / safe
    pp = dot(ap, ap)
    inside = (scale > 0) & (v >= 0) & (w >= 0) & (v + w <= 1)
    plane = pp - v * d20 - w * d21
    edges = []
    for length, along, square in (
        (d00, d20, pp),
        (d11, d21, pp),
        (d00 - 2 * d01 + d11, d21 - d20 + d00 - d01, pp - 2 * d20 + d00),
    ):
        t = np.clip(along / np.where(length > 0, length, 1), 0, 1)
        edges.append(square - 2 * t * along + t * t * length)
    nearest = np.minimum(np.minimum(edges[0], edges[1]), edges[2])
    return np.maximum(np.where(inside, plane, nearest), 0)


class _Trial:
    """Points of the surface and where they are on the sphere: the same for all rotations."""

    def __init__(self, sphere: Points, surface: Points, faces: Faces) -> None:
        rng = np.random.default_rng(0)
        a, b, c = (surface[faces[:, k]] for k in range(3))
        area = np.cumsum(np.linalg.norm(np.cross(b - a, c - a), axis=1))
        chosen = np.searchsorted(area, rng.random(SAMPLES) * area[-1], side="right")
        corners = faces[np.minimum(chosen, len(faces) - 1)]
        root, along = np.sqrt(rng.random(SAMPLES)), rng.random(SAMPLES)
        weights = np.stack([1 - root, root * (1 - along), root * along], axis=1)
        self.points = np.einsum("kc,kci->ki", weights, surface[corners])
        self.directions = np.einsum("kc,kci->ki", weights, sphere[corners])

    def error(self, image: Points, rotation: Points) -> float:
        """Root mean square distance of the points to the image's triangles near where they lie in it."""
        last = image.shape[0] - 1
        at = (octahedron.to_square(self.directions @ rotation.T) + 1) / 2 * last
        cell = np.clip(at.astype(np.int64), 0, last - 1)
        best = np.full(len(self.points), np.inf)
        for dy in range(-REACH, REACH + 1):
            for dx in range(-REACH, REACH + 1):
                x = np.clip(cell[:, 0] + dx, 0, last - 1)
                y = np.clip(cell[:, 1] + dy, 0, last - 1)
                p, q, r, s = image[y, x], image[y, x + 1], image[y + 1, x + 1], image[y + 1, x]
                anti = ((2 * x >= last) == (2 * y >= last))[:, None]
                one, two = np.where(anti, q, p), np.where(anti, s, r)
                for third in (np.where(anti, p, q), np.where(anti, r, s)):
                    best = np.minimum(best, squared_distances(self.points, one, two, third))
        return float(np.sqrt(best.mean()))


def choose(sphere: Points, surface: Points, faces: Faces, locator: Locator) -> Points:
    """The rotation whose small image lies nearest to the surface: (3, 3).

    Args:
        sphere: (n, 3) float64, one to one.
        surface: (n, 3) float64, the same vertices in space.
        faces: (m, 3) int64.
        locator: of this sphere.
    """
    trial = _Trial(sphere, surface, faces)
    rotations = candidates()
    errors = []
    for rotation in rotations:
        face, weights = locator.image(TRIAL_LEVEL, rotation)
        image = np.einsum("rck,rcki->rci", weights, surface[faces[face]])
        errors.append(trial.error(image, rotation))
    return rotations[int(np.argmin(errors))]
