"""The quadtree, its filter and its merge in numpy, float64, written for reading; the node's choice is in float32."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import GeometryImage, TriangleMesh
from lodbench.kernels.geometry_image.parameterisation.octahedron import canonical
from lodbench.kernels.geometry_image.quadtree_lod.fit import anti_diagonal
from lodbench.kernels.geometry_image.quadtree_lod.view import LodCriterion

Levels = list[NDArray[Any]]
COARSE, NOTHING, DRAWN = 0, 1, 2


def packed_slice(depth: int, n: int) -> tuple[slice, slice]:
    """Rows and columns of a level in the packed texture of 3 * 2^(n-1) rows.

    Source: Wang et al., figure 3; the coordinates are a reconstruction.
    """
    side, size = 1 << n, 1 << depth
    if depth == n:
        return slice(0, side), slice(0, side)
    return slice(side, side + size), slice(size, 2 * size)


def unpack(texels: NDArray[Any], n: int) -> Levels:
    """A packed texture, (3 * 2^(2n-1),), as one array per depth, 0 to n: (2^d, 2^d), row y, column x."""
    packed = texels.reshape(-1, 1 << n)
    return [packed[packed_slice(depth, n)] for depth in range(n + 1)]


def unpack_upper(texels: NDArray[Any], n: int) -> Levels:
    """The same for a texture without its leaves: one array per depth, 0 to n - 1."""
    side = 1 << n
    packed = texels.reshape(-1, side, *texels.shape[1:])
    return [
        packed[rows.start - side : rows.stop - side, columns]
        for rows, columns in (packed_slice(depth, n) for depth in range(n))
    ]


def node_errors(places: Levels, per_area: float = 0.0) -> Levels:
    """Per depth, how far a node's samples lie from its two triangles, or its children's do: float64.

    Args:
        places: per depth, where the level's vertices lie; the last is the image itself.
        per_area: one over the whole area: root of the squared distance's integral over the node, times this; 0: the
            largest distance.
    """
    samples = places[-1].astype(np.float64)
    n = len(places) - 1
    levels: Levels = [np.zeros((1 << n, 1 << n))]
    for depth in reversed(range(n)):
        size, count = 1 << (n - depth), 1 << depth
        columns = size * np.arange(count)[:, None] + np.arange(size + 1)
        anti, corner = anti_diagonal(depth), places[depth].astype(np.float64)
        own = np.empty((count, count))
        for y in range(count):
            nodes = samples[y * size : (y + 1) * size + 1][:, columns].transpose(1, 0, 2, 3)
            corners = (corner[y, :-1], corner[y, 1:], corner[y + 1, 1:], corner[y + 1, :-1])
            apart = nodes - _flat(corners, size, anti[y])
            square = np.einsum("njik,njik->nji", apart, apart)
            if per_area:
                own[y] = np.sqrt((square * _areas(nodes)).sum(axis=(1, 2)) * per_area)
            else:
                own[y] = np.sqrt(square.max(axis=(1, 2)))
        below = levels[0].reshape(count, 2, count, 2).max(axis=(1, 3))
        levels.insert(0, np.maximum(own, below))
    return levels


def _flat(
    corners: tuple[NDArray[np.float64], ...], size: int, anti: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Each node's two triangles, evaluated where its samples are: (nodes, rows, columns, 3)."""
    v, u = np.indices((size + 1, size + 1)) / size
    p, q, r, s = (points[:, None, None] for points in corners)
    lower_left, lower_right = (u + v <= 1)[..., None], (u >= v)[..., None]
    u, v = u[..., None], v[..., None]
    across = np.where(
        lower_left, p + u * (q - p) + v * (s - p), r + (1 - u) * (s - r) + (1 - v) * (q - r)
    )
    along = np.where(lower_right, p + u * (q - p) + v * (r - q), p + v * (s - p) + u * (r - s))
    return np.where(anti[:, None, None, None], across, along)


def _areas(nodes: NDArray[np.float64]) -> NDArray[np.float64]:
    """The area around each sample of a node, as far as it lies in the node: (nodes, rows, columns)."""
    padded = np.pad(nodes, ((0, 0), (1, 1), (1, 1), (0, 0)), mode="edge")
    across = padded[:, 1:-1, 2:] - padded[:, 1:-1, :-2]
    up = padded[:, 2:, 1:-1] - padded[:, :-2, 1:-1]
    return np.linalg.norm(np.cross(across, up), axis=-1) / 4


def fine_nodes(errors: Levels, bounds: Levels, criterion: LodCriterion) -> Levels:
    """Per depth, is the node's error small enough? The device's float32 expression, rounding for rounding."""
    fine = []
    for depth, error in enumerate(errors[:-1]):
        if not criterion.per_node:
            fine.append(error < np.float32(criterion.threshold))
            continue
        eye = np.array(criterion.eye_scale[:3], np.float32)
        near, slack = (np.float32(value) for value in criterion.near_slack)
        apart = bounds[depth][..., :3] - eye
        x, y, z = (apart[..., k] for k in range(3))
        away = (np.sqrt(x * x + y * y + z * z) - bounds[depth][..., 3]) + np.float32(depth) * slack
        fine.append(error * np.float32(criterion.eye_scale[3]) < np.maximum(away, near))
    fine[0][:] = False  # the root's four corners are one point
    return [*fine, np.ones(errors[-1].shape, bool)]


def node_states(fine: Levels) -> Levels:
    """Per depth: drawn where fine and the parent is not; nothing to draw below a fine node.

    Source: Wang et al., section 3.2, steps 1-4.
    """
    states = [np.full((1, 1), COARSE, np.uint8)]
    for depth in range(1, len(fine)):
        above = np.repeat(np.repeat(states[-1], 2, axis=0), 2, axis=1)
        own = np.where(fine[depth], DRAWN, COARSE)
        states.append(np.where(above == COARSE, own, NOTHING).astype(np.uint8))
    return states


def corner_flags(states: Levels) -> NDArray[np.bool_]:
    """Which samples are corners of drawn nodes, seam duplicates alike: (side, side)."""
    n = len(states) - 1
    side = (1 << n) + 1
    own = canonical(n).ravel()
    flags = np.zeros(side * side, bool)
    for depth, level in enumerate(states):
        size = 1 << (n - depth)
        y, x = np.nonzero(level == DRAWN)
        for dx, dy in ((0, 0), (1, 0), (1, 1), (0, 1)):
            flags[own[(y + dy) * size * side + (x + dx) * size]] = True
    return flags[own].reshape(side, side)


def merge(image: GeometryImage, states: Levels, places: Levels | None = None) -> TriangleMesh:
    """The drawn nodes' triangles: two where no neighbour is finer, else a fan about the centre.

    Vertices lie where `places` has them at the depth of the finest node around, or on the image's samples.

    Vertices come row by row of the image, triangles row by row of the packed texture.

    Source: Wang et al., section 3.2, figure 4; the fan over the perimeter is a reconstruction.
    """
    n = len(states) - 1
    side = (1 << n) + 1
    own = canonical(n)
    flags = corner_flags(states)
    used = flags.copy()
    texels, triangles = [], []
    for depth in range(1, n + 1):
        size = 1 << (n - depth)
        y, x = np.nonzero(states[depth] == DRAWN)
        rows, columns = _perimeters(y * size, x * size, size)
        corner = flags[rows, columns]
        plain = corner.sum(axis=1) == 4
        top, left = (part.start for part in packed_slice(depth, n))
        texel = ((top + y) << n) + left + x
        texels.append(np.repeat(texel[plain], 2))
        triangles.append(_two_triangles(y[plain], x[plain], size, n, own))
        fans = np.flatnonzero(~plain)
        middle = (y[fans] * size + size // 2, x[fans] * size + size // 2)
        used[middle] = True
        node, at = np.nonzero(corner[fans])
        around = own[rows[fans[node], at], columns[fans[node], at]]
        # the next corner of the same node; the last one's is the node's first
        first = np.searchsorted(node, np.arange(len(fans)))
        after = np.arange(1, len(node) + 1)
        after[np.append(first, len(node))[1:] - 1] = first
        texels.append(texel[fans[node]])
        triangles.append(np.stack([own[middle][node], around, around[after]], axis=1))
    order = np.argsort(np.concatenate(texels), kind="stable")
    samples = np.flatnonzero(used.ravel() & (own.ravel() == np.arange(side * side)))
    faces = np.searchsorted(samples, np.concatenate(triangles)[order])
    positions = image.positions.reshape(-1, 3)[samples]
    if places is not None:
        depths = vertex_depths(states).ravel()[samples]
        for depth in range(1, n):
            here = np.flatnonzero(depths == depth)
            row, column = np.divmod(samples[here], side)
            positions[here] = places[depth][row >> (n - depth), column >> (n - depth)]
    return TriangleMesh(positions, faces, image.normals.reshape(-1, 3)[samples])


def vertex_depths(states: Levels) -> NDArray[np.int64]:
    """Per sample, the depth of the finest drawn node with it as a corner, and one more at a node's centre."""
    n = len(states) - 1
    side = (1 << n) + 1
    own = canonical(n)
    found = np.zeros(side * side, np.int64)
    for depth, level in enumerate(states):
        size = 1 << (n - depth)
        y, x = np.nonzero(level == DRAWN)
        for dx, dy in ((0, 0), (1, 0), (1, 1), (0, 1)):
            np.maximum.at(found, own[(y + dy) * size, (x + dx) * size], depth)
        if size > 1:
            np.maximum.at(found, own[y * size + size // 2, x * size + size // 2], depth + 1)
    return found[own]


def _perimeters(
    low: NDArray[np.integer], left: NDArray[np.integer], size: int
) -> tuple[NDArray[np.integer], NDArray[np.integer]]:
    """Rows and columns of the samples around each node, counter-clockwise from its first corner: (nodes, 4 * size)."""
    step, zero, full = np.arange(size), np.zeros(size, int), np.full(size, size)
    down = np.concatenate([zero, step, full, size - step])
    right = np.concatenate([step, full, size - step, zero])
    return low[:, None] + down, left[:, None] + right


def _two_triangles(
    y: NDArray[np.integer], x: NDArray[np.integer], size: int, n: int, own: NDArray[np.int64]
) -> NDArray[np.int64]:
    p, q = own[y * size, x * size], own[y * size, (x + 1) * size]
    r, s = own[(y + 1) * size, (x + 1) * size], own[(y + 1) * size, x * size]
    anti = anti_diagonal(n - size.bit_length() + 1)[y, x][:, None]
    one = np.where(anti, np.stack([p, q, s], 1), np.stack([p, q, r], 1))
    two = np.where(anti, np.stack([q, r, s], 1), np.stack([p, r, s], 1))
    return np.stack([one, two], axis=1).reshape(-1, 3)
