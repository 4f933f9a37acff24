"""The quadtree, its filter and its merge in numpy, float64, written for reading; the node's choice is in float32."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import GeometryImage, TriangleMesh
from lodbench.kernels.geometry_image.parameterisation.octahedron import canonical
from lodbench.kernels.geometry_image.quadtree_lod.view import Detail
from lodbench.kernels.system import Check

if TYPE_CHECKING:
    from lodbench.kernels.geometry_image.quadtree_lod.host import QuadtreeLod

Levels = list[NDArray[Any]]
COARSE, NOTHING, DRAWN = 0, 1, 2
ERROR_TOLERANCE = 4e-6
"""A node's error in float32 against float64, of the diagonal: the difference of two points and their interpolation."""


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


def anti_diagonal(depth: int) -> NDArray[np.bool_]:
    """Does each node's diagonal run from right below to left above? (2^d, 2^d)."""
    right = 2 * np.arange(1 << depth) + 1 >= 1 << depth
    return right[:, None] == right[None, :]


def node_errors(image: GeometryImage) -> Levels:
    """Per depth, the largest distance of a node's samples from its two triangles, or of its children's: float64."""
    samples = image.positions.astype(np.float64)
    n = (len(samples) - 1).bit_length() - 1
    levels: Levels = [np.zeros((1 << n, 1 << n))]
    for depth in reversed(range(n)):
        size, count = 1 << (n - depth), 1 << depth
        corner = samples[::size, ::size]
        p, q, r, s = corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]
        anti = anti_diagonal(depth)[..., None]
        worst = np.zeros((count, count))
        for j in range(size + 1):
            for i in range(size + 1):
                u, v = i / size, j / size
                across = (
                    p + u * (q - p) + v * (s - p)
                    if u + v <= 1
                    else r + (1 - u) * (s - r) + (1 - v) * (q - r)
                )
                along = p + u * (q - p) + v * (r - q) if u >= v else p + v * (s - p) + u * (r - s)
                here = samples[j::size, i::size][:count, :count]
                apart = here - np.where(anti, across, along)
                worst = np.maximum(worst, np.sqrt((apart**2).sum(-1)))
        below = levels[0].reshape(count, 2, count, 2).max(axis=(1, 3))
        levels.insert(0, np.maximum(worst, below))
    return levels


def fine_nodes(errors: Levels, bounds: Levels, detail: Detail) -> Levels:
    """Per depth, is the node's error small enough? The device's float32 expression, rounding for rounding."""
    fine = []
    for depth, error in enumerate(errors[:-1]):
        if detail.eye_scale is None:
            fine.append(error < np.float32(detail.threshold))
            continue
        eye = np.array(detail.eye_scale[:3], np.float32)
        near, slack = (np.float32(value) for value in detail.near_slack)
        apart = bounds[depth][..., :3] - eye
        x, y, z = (apart[..., k] for k in range(3))
        away = (np.sqrt(x * x + y * y + z * z) - bounds[depth][..., 3]) + np.float32(depth) * slack
        fine.append(error * np.float32(detail.eye_scale[3]) < np.maximum(away, near))
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
    """Which samples are corners of drawn nodes, border twins alike: (side, side)."""
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


def _perimeter(flags: NDArray[np.bool_], x: int, y: int, size: int) -> list[tuple[int, int]]:
    """A node's corners and its neighbours' corners on its edges, counter-clockwise: (row, column)."""
    ring = [(y, x + k) for k in range(size)]
    ring += [(y + k, x + size) for k in range(size)]
    ring += [(y + size, x + size - k) for k in range(size)]
    ring += [(y + size - k, x) for k in range(size)]
    return [at for at in ring if flags[at]]


def merge(image: GeometryImage, states: Levels) -> TriangleMesh:
    """The drawn nodes' triangles: two where no neighbour is finer, else a fan about the centre; vertices row by row.

    Source: Wang et al., section 3.2, figure 4; the perimeter is a reconstruction.
    """
    n = len(states) - 1
    side = (1 << n) + 1
    own = canonical(n)
    flags = corner_flags(states)
    used = flags.copy()
    triangles = [_two_triangles(np.nonzero(states[n] == DRAWN), 1, n, own)]
    # the packed texture is read row by row: below depth n the nodes of one row come from all levels
    upper = []
    for depth in range(1, n):
        y, x = np.nonzero(states[depth] == DRAWN)
        upper += [(int(b), depth, int(a)) for a, b in zip(x, y, strict=True)]
    for y, depth, x in sorted(upper):
        size = 1 << (n - depth)
        ring = _perimeter(flags, x * size, y * size, size)
        if len(ring) == 4:
            triangles.append(_two_triangles((np.array([y]), np.array([x])), size, n, own))
            continue
        centre = (y * size + size // 2, x * size + size // 2)
        used[centre] = True
        around = np.array([own[at] for at in ring])
        fan = np.stack([np.full(len(around), own[centre]), around, np.roll(around, -1)], axis=1)
        triangles.append(fan)
    samples = np.flatnonzero(used.ravel() & (own.ravel() == np.arange(side * side)))
    faces = np.searchsorted(samples, np.concatenate(triangles))
    return TriangleMesh(
        image.positions.reshape(-1, 3)[samples], faces, image.normals.reshape(-1, 3)[samples]
    )


def _two_triangles(
    nodes: tuple[NDArray[np.integer], ...], size: int, n: int, own: NDArray[np.int64]
) -> NDArray[np.int64]:
    y, x = nodes
    p, q = own[y * size, x * size], own[y * size, (x + 1) * size]
    r, s = own[(y + 1) * size, (x + 1) * size], own[(y + 1) * size, x * size]
    anti = anti_diagonal(n - size.bit_length() + 1)[y, x][:, None]
    one = np.where(anti, np.stack([p, q, s], 1), np.stack([p, q, r], 1))
    two = np.where(anti, np.stack([q, r, s], 1), np.stack([p, r, s], 1))
    return np.stack([one, two], axis=1).reshape(-1, 3)


def judge(prepared: QuadtreeLod) -> Check:
    """Share of output values that differ from the reference; the tree's errors must be right first."""
    what = "vertices and triangles that differ from the reference"
    mesh = prepared.result()[0]
    image = prepared.image
    if image is None:
        return Check(mesh.triangle_count == 0, what, float(mesh.triangle_count), 0.0)
    errors = prepared.tree.read_errors()
    exact = node_errors(image)
    scale = prepared.tree.diagonal or 1.0
    wrong = max(float(np.abs(a - b).max()) for a, b in zip(errors[1:], exact[1:], strict=True))
    if wrong > ERROR_TOLERANCE * scale:
        text = "largest deviation of a node's error, of the diagonal"
        return Check(False, text, wrong / scale, ERROR_TOLERANCE)
    assert prepared.last is not None
    fine = fine_nodes(errors, prepared.tree.read_bounds(), prepared.last)
    expected = merge(image, node_states(fine))
    same = (
        mesh.positions.shape == expected.positions.shape
        and mesh.triangles.shape == expected.triangles.shape
    )
    differing = (
        float(
            (mesh.positions != expected.positions).any(axis=1).sum()
            + (mesh.triangles != expected.triangles).any(axis=1).sum()
        )
        if same
        else float(abs(mesh.triangle_count - expected.triangle_count) or 1)
    )
    return Check(differing == 0, what, differing, 0.0)
