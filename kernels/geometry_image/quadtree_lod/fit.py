"""Where the vertices of each level lie: on the image's own samples, or where they fit the full image best."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array, diags_array
from scipy.sparse.linalg import cg

from lodbench.datasets_gen.surfaces import GeometryImage
from lodbench.kernels.geometry_image.parameterisation.octahedron import canonical

Points = NDArray[np.float64]
ROUGH = 1e-4  # of the right-hand side; a mass matrix gains a digit in four or five steps
STEPS = 60


def anti_diagonal(depth: int) -> NDArray[np.bool_]:
    """Does each node's diagonal run from right below to left above? (2^d, 2^d)."""
    right = 2 * np.arange(1 << depth) + 1 >= 1 << depth
    return right[:, None] == right[None, :]


def sample_areas(samples: Points) -> NDArray[np.float64]:
    """Each sample's share of the surface, a quarter of every cell around it, seam duplicates added up: (side, side)."""
    side = len(samples)
    p, q, r, s = samples[:-1, :-1], samples[:-1, 1:], samples[1:, 1:], samples[1:, :-1]
    cell = sum(
        np.linalg.norm(np.cross(b - a, c - a), axis=-1) / 2 for a, b, c in ((p, q, s), (r, s, q))
    )
    area = np.zeros((side, side))
    for y in (slice(0, -1), slice(1, None)):
        for x in (slice(0, -1), slice(1, None)):
            area[y, x] += cell / 4
    own = canonical((side - 1).bit_length() - 1)
    return np.bincount(own.ravel(), area.ravel(), side * side)[own]  # pyright: ignore[reportReturnType]


def hat_weights(depth: int, n: int) -> csr_array:
    """Each canonical sample of the full image as a mean of a level's vertices: (samples, (2^d + 1)^2).

    Rows and columns of seam duplicates stay empty: the sample that stands for them has theirs.
    """
    last, count = 1 << n, 1 << depth
    size = last // count
    own = canonical(n).ravel()
    at = np.flatnonzero(own == np.arange(len(own)))
    j, i = np.divmod(at, last + 1)
    x, y = np.minimum(i // size, count - 1), np.minimum(j // size, count - 1)
    u, v = i / size - x, j / size - y
    anti = anti_diagonal(depth)[y, x]
    low, right = u + v <= 1, u >= v
    weights = np.select(
        [(anti & low)[:, None], anti[:, None], right[:, None]],
        [
            np.stack([1 - u - v, u, 0 * u, v], 1),
            np.stack([0 * u, 1 - v, u + v - 1, 1 - u], 1),
            np.stack([1 - u, u - v, v, 0 * u], 1),
        ],
        np.stack([1 - v, 0 * u, u, v - u], 1),
    )
    corner = y * (count + 1) + x
    columns = np.stack([corner, corner + 1, corner + count + 2, corner + count + 1], 1)
    columns = canonical(depth).ravel()[columns]
    rows = np.repeat(at, 4)
    shape = (len(own), (count + 1) ** 2)
    return csr_array(coo_array((weights.ravel(), (rows, columns.ravel())), shape=shape))


def fitted(image: GeometryImage, depth: int) -> NDArray[np.float32]:
    """Vertices of a level's uniform mesh with the least squared distance, over the area, to the image: float32.

    Source: the least squares of Hoppe 1993 (mesh optimization), section 4, with the image's parameters for the
    projections; Wang et al. take the samples as they are.
    """
    samples = image.positions.astype(np.float64)
    n = (len(samples) - 1).bit_length() - 1
    start = samples[:: 1 << (n - depth), :: 1 << (n - depth)]
    own = canonical(depth).ravel()
    hats = hat_weights(depth, n)
    area = sample_areas(samples).ravel()
    used = np.unique(own)
    hats = hats[:, used]
    weighted = csr_array(hats.T @ diags_array(area))
    normal = csr_array(weighted @ hats)
    diagonal = normal.diagonal()
    # a vertex whose hat covers no area stays where it is
    ridge = np.where(diagonal > 0, 1e-6 * diagonal, 1.0)
    normal = csr_array(normal + diags_array(ridge))
    inverse = diags_array(1 / (diagonal + ridge))
    flat, begin = samples.reshape(-1, 3), start.reshape(-1, 3)[used]
    found = np.empty_like(begin)
    for k in range(3):
        right = weighted @ flat[:, k] + ridge * begin[:, k]
        found[:, k], _ = cg(normal, right, x0=begin[:, k], rtol=ROUGH, maxiter=STEPS, M=inverse)
    result = np.zeros(((1 << depth) + 1) ** 2 * 3).reshape(-1, 3)
    result[used] = found
    most = float(np.finfo(np.float32).max)  # a fit may lie a little outside of what it fits
    return np.clip(result[own], -most, most).reshape(start.shape).astype(np.float32)


def pyramid(image: GeometryImage, placement: str) -> list[NDArray[np.float32]]:
    """Per depth, 0 to n, where a level's vertices lie, (2^d + 1, 2^d + 1, 3) float32; the last is the image.

    Args:
        image: (2^n + 1)^2 samples.
        placement: "samples" or "fitted".
    """
    n = (len(image.positions) - 1).bit_length() - 1
    levels = []
    for depth in range(n):
        step = 1 << (n - depth)
        fits = placement == "fitted" and depth > 0
        levels.append(fitted(image, depth) if fits else image.positions[::step, ::step].copy())
    return [*levels, image.positions]
