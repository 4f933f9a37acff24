"""Bicubic Bezier patch sets: read from .npz and .bpt, or made as surfaces of revolution."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.arrays import BROKEN
from lodbench.datasets_gen.names import FOLDERS
from lodbench.datasets_gen.ply import numbers_in
from lodbench.datasets_gen.read import FileError
from lodbench.datasets_gen.surfaces import BezierPatches

ZIP = b"PK"  # an .npz begins so
SUFFIXES = FOLDERS["bezier"]
_QUARTER = 4 / 3 * (2**0.5 - 1)
"""Length of the tangents with which one cubic stays nearest to a quarter of the unit circle."""


def read_patches(path: str | Path) -> BezierPatches:
    """Patches from .npz (key `patches`, (n, 4, 4, 3)) or .bpt (count, then `3 3` and 16 points each).

    Raises:
        FileError: no such file, an unknown suffix, truncated, not bicubic, NaN.
    """
    path = Path(path)
    if path.suffix.lower() not in (".npz", ".bpt"):
        raise FileError(f"{path}: expected a suffix of {' '.join(SUFFIXES)}, got {path.suffix!r}")
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise FileError(f"{path}: no such file") from None
    except OSError as error:
        raise FileError(f"{path}: {error.strerror}") from None
    return parse_patches(data, path)


def parse_patches(data: bytes, name: str | Path) -> BezierPatches:
    """The patches in a file's bytes, .npz or else .bpt: what `read_patches` does with them.

    Raises:
        FileError: as there; `name` stands in its text.
    """
    try:
        if not data.startswith(ZIP) and Path(name).suffix.lower() != ".npz":
            return BezierPatches(_bpt_points(numbers_in(data)))
        with np.load(io.BytesIO(data), allow_pickle=False) as archive:
            if "patches" not in archive:
                raise ValueError(f"expected the key 'patches', got {sorted(archive)}")
            patches = BezierPatches(archive["patches"])
            if not len(patches.points):
                raise ValueError("patches: expected at least one, got none")
            return patches
    except BROKEN as error:
        raise FileError(f"{name}: {' '.join(str(error).split())}") from error


def _bpt_points(numbers: NDArray[np.float64]) -> NDArray[np.float64]:
    """The control points, (n, 4, 4, 3), of a .bpt file's numbers."""
    if len(numbers) > 2 and tuple(numbers[1:3]) != (3, 3):
        raise ValueError(f"expected patches of degree 3 3, got {numbers[1]:g} {numbers[2]:g}")
    count = int(numbers[0]) if len(numbers) and np.isfinite(numbers[0]) else 0
    if count < 1:
        raise ValueError("expected a number of patches, got none")
    if len(numbers) != 1 + 50 * count:
        raise ValueError(f"expected {count} bicubic patches, got {len(numbers)} numbers")
    table = numbers[1:].reshape(count, 50)
    if (table[:, :2] != 3).any():
        raise ValueError("expected patches of degree 3 3, got another degree")
    return table[:, 2:].reshape(count, 4, 4, 3)


def _smooth_curve(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cubic segments (n - 1, 4, 2) through `points` (n, 2), with one tangent where two meet (Catmull-Rom)."""
    slopes = np.gradient(points, axis=0)
    start, end = points[:-1], points[1:]
    return np.stack([start, start + slopes[:-1] / 3, end - slopes[1:] / 3, end], axis=1)


def revolution(profile: NDArray[np.float64]) -> BezierPatches:
    """Four patches around z per cubic segment of the `profile`, (n, 4, 2): radius and height, upwards.

    u runs around, v along the profile, normals point outwards. A quarter circle is one cubic, which is at
    most 0.03 % of the radius off.
    """
    axes = np.array([(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)])
    start, end = axes, np.roll(axes, -1, axis=0)
    arcs = np.stack([start, start + _QUARTER * end, end + _QUARTER * start, end], axis=1)
    flat = arcs[None, :, :, None, :] * profile[:, None, None, :, 0, None]
    height = np.broadcast_to(profile[:, None, None, :, 1, None], (*flat.shape[:-1], 1))
    return BezierPatches(np.concatenate([flat, height], axis=-1).reshape(-1, 4, 4, 3))


def pot(segments: int) -> BezierPatches:
    """A closed round pot with a neck, 4 * segments patches; those at both poles have a collapsed edge."""
    t = np.linspace(0, np.pi, segments + 1)
    radius = np.sin(t) * (1.2 + 0.35 * np.sin(2.6 * t) + 0.08 * np.cos(7 * t))
    radius[[0, -1]] = 0.0  # exactly, so that the pole is one point
    return revolution(_smooth_curve(np.stack([radius, 1.3 * (1 - np.cos(t))], axis=1)))


def cup() -> BezierPatches:
    """An open cup of 24 patches with a handle of two: 26, with borders at the rim and the handle's ends."""
    t = np.linspace(0, 1, 7)
    radius = 0.9 * np.sqrt(t) * (1 + 0.15 * t)
    bowl = revolution(_smooth_curve(np.stack([radius, t**2], axis=1)))
    path = np.array([(0.75, 0.85), (1.5, 1.1), (1.5, 0.1), (0.6, 0.3)])
    across = np.array([(0.4, 1.0), (1.0, 0.6), (1.0, -0.6), (0.4, -1.0)])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    side = np.array([(0.0, 1.0), (4 / 3, 1.0), (4 / 3, -1.0), (0.0, -1.0)]) * 0.06
    centre = np.stack([path[:, 0], 0 * path[:, 0], path[:, 1]], axis=1)
    out = np.stack([across[:, 0], 0 * across[:, 0], across[:, 1]], axis=1)
    handle = [
        centre[:, None] + sign * (out[:, None] * side[:, :1] + side[:, 1:] * (0.0, 1.0, 0.0))
        for sign in (1, -1)
    ]
    return BezierPatches(np.concatenate([bowl.points, np.array(handle)]))


class Made(Protocol):
    """What has a surface, such as an entry of the catalogue."""

    @property
    def surface(self) -> object:
        """Made or read when it is asked for."""
        ...


def scene(one: Made, count: int) -> BezierPatches:
    """`copies` of patches that are made or read only now."""
    surface = one.surface
    assert isinstance(surface, BezierPatches)
    return copies(surface, count)


def copies(patches: BezierPatches, count: int) -> BezierPatches:
    """`count` copies side by side on a square grid, none touching: the scenes that the tables replicate."""
    points = patches.points.astype(np.float64)
    size = points.max((0, 1, 2)) - points.min((0, 1, 2))
    columns = int(np.ceil(np.sqrt(count)))
    row, column = np.divmod(np.arange(count), columns)
    shift = np.stack([column, row, 0 * row], axis=1) * size * 1.25
    return BezierPatches((shift[:, None, None, None] + points).reshape(-1, 4, 4, 3))
