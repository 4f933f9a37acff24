"""Cameras: where the eye is and what it sees, as a `View`."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lodbench.datasets_gen.arrays import box
from lodbench.kernels.system import View

TABLE_SIZE = (
    1280,
    1024,
)  # of the tables: the size that Boubekeur & Schlick and Concheiro measured at
FOV_Y = 45.0  # degrees
ORDINARY = 60  # powers of two by which a world may differ from 1 and still be transformed as it is
FARTHEST = 100  # powers of two that a transform's entries may reach; float32 ends at 128
ROOM = 20  # powers of two above 1 for what is added, so that a rotation keeps its digits in a large world

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def _size(size: tuple[int, int]) -> tuple[int, int]:
    width, height = (int(n) for n in size)
    if not (1 <= width <= 16384 and 1 <= height <= 16384):
        raise ValueError(f"size: expected 1 to 16384 pixels per side, got {width} x {height}")
    return width, height


def _basis(back: NDArray[np.float64], up: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rows right, up and back of a camera that looks along -back; another up where it lies along the view."""
    right = np.cross(up, back)
    if np.linalg.norm(right) < 1e-9 * max(float(np.linalg.norm(up)), 1e-300):
        right = np.cross(_AXES["z"] if abs(back[2]) < 0.9 else _AXES["x"], back)
    right = right / np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back])


def look_at(
    eye: ArrayLike,
    target: ArrayLike,
    up: ArrayLike = _AXES["y"],
    fov_y: float = FOV_Y,
    size: tuple[int, int] = TABLE_SIZE,
    near: float | None = None,
    far: float | None = None,
) -> View:
    """A perspective view from `eye` to `target`.

    Args:
        eye: (3,) model units.
        target: (3,) model units, other than the eye.
        up: (3,) what shall point upwards in the image; replaced where it is along the view.
        fov_y: whole vertical angle, degrees, above 0 and below 180.
        size: width and height, pixels, 1 to 16384 each.
        near: distance of the near plane, model units; None: a thousandth of the distance to the target.
        far: distance of the far plane; None: a hundred times the distance to the target.

    Raises:
        ValueError: a value out of its range.
    """
    width, height = _size(size)
    eye, target, up = (np.asarray(a, np.float64) for a in (eye, target, up))
    back = eye - target
    distance = float(np.linalg.norm(back))
    if not (np.isfinite(distance) and distance > 0):
        raise ValueError(f"target: expected a finite point other than the eye, got {target}")
    if not 0 < fov_y < 180:
        raise ValueError(f"fov_y: expected degrees between 0 and 180, got {fov_y}")
    near = distance * 1e-3 if near is None else float(near)
    far = distance * 1e2 if far is None else float(far)
    if not 0 < near < far:
        raise ValueError(f"near, far: expected 0 < near < far, got {near}, {far}")
    basis = _basis(back / distance, up)
    camera = np.eye(4)
    camera[:3, :3] = basis
    camera[:3, 3] = -basis @ eye
    focal = 1.0 / np.tan(np.radians(fov_y) / 2)
    clip = np.zeros((4, 4))
    clip[0, 0] = focal * height / width
    clip[1, 1] = focal
    clip[2, 2] = (far + near) / (near - far)
    clip[2, 3] = 2 * far * near / (near - far)
    clip[3, 2] = -1.0
    return View(eye, clip @ camera, width, height)


def _direction(azimuth: float, elevation: float) -> NDArray[np.float64]:
    around, above = np.radians(azimuth), np.radians(elevation)
    level = np.cos(above)
    return np.array([np.sin(around) * level, np.sin(above), np.cos(around) * level])


def orbit(
    target: ArrayLike,
    distance: float,
    azimuth: float = 30.0,
    elevation: float = 20.0,
    fov: float = FOV_Y,
    size: tuple[int, int] = TABLE_SIZE,
) -> View:
    """A view of `target` from `distance`, turned by azimuth and elevation.

    Azimuth 0 looks along -z, 90 along -x; elevation 90 looks straight down -y. Angles in degrees, y is up.
    """
    target = np.asarray(target, np.float64)
    return look_at(target + distance * _direction(azimuth, elevation), target, fov_y=fov, size=size)


def fit_points(
    points: ArrayLike,
    direction: ArrayLike = (0.5, 0.35, 0.8),
    size: tuple[int, int] = TABLE_SIZE,
    fov_y: float = FOV_Y,
    margin: float = 1.06,
    up: ArrayLike = _AXES["y"],
) -> View:
    """The nearest view along `direction` that has all points in the image, in its middle.

    Args:
        points: (n, 3) model units, n at least 1.
        direction: (3,) from the points towards the eye.
        size: width and height, pixels.
        fov_y: whole vertical angle, degrees.
        margin: 1 touches the border; 1.06 leaves 6 % of the half size free.
        up: (3,) what points upwards in the image.

    Raises:
        ValueError: a value out of its range.
    """
    points = np.asarray(points, np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or not len(points) or not np.isfinite(points).all():
        raise ValueError(f"points: expected finite (n, 3), n at least 1, got shape {points.shape}")
    direction = np.asarray(direction, np.float64)
    length = float(np.linalg.norm(direction))
    if not (np.isfinite(length) and length > 0):
        raise ValueError(f"direction: expected a finite vector that is not zero, got {direction}")
    low, high = box(points)
    centre = (low + high) / 2
    radius = float(np.linalg.norm(high - low)) / 2 or max(float(np.abs(centre).max()), 1.0) * 1e-3
    width, height = _size(size)
    right, upright, back = _basis(direction / length, np.asarray(up, np.float64))
    u, v, toward = ((points - centre) @ axis for axis in (right, upright, back))
    # a point is left of the right border where u + s toward <= eye_u + s distance, s the slope of that border
    slope_y = float(np.tan(np.radians(fov_y) / 2)) / margin
    slope_x = slope_y * width / height
    ends = [
        (float((p + s * toward).max()), float((-p + s * toward).max()), s)
        for p, s in ((u, slope_x), (v, slope_y))
    ]
    distance = max(max((a + b) / (2 * s) for a, b, s in ends), float(toward.max()) + 1e-3 * radius)
    depth = distance - toward
    middle = centre
    for axis, places, (a, b, _) in ((right, u, ends[0]), (upright, v, ends[1])):
        middle = middle + axis * _in_the_middle(places, depth, (a - b) / 2)
    nearest, farthest = distance - float(toward.max()), distance - float(toward.min())
    return look_at(
        middle + back * distance,
        middle,
        up,
        fov_y,
        size,
        near=max(nearest * 0.5, distance * 1e-4),
        far=max(farthest * 1.5, distance * 1e-3),
    )


def distance_to_show(
    points: ArrayLike,
    target: ArrayLike,
    direction: ArrayLike,
    size: tuple[int, int] = TABLE_SIZE,
    fov_y: float = FOV_Y,
    margin: float = 1.06,
    up: ArrayLike = _AXES["y"],
) -> float:
    """How far from `target`, along `direction`, an eye that looks at it has all points in the image.

    The arguments are those of `fit_points`, which moves the eye aside where that brings it nearer.
    """
    direction = np.asarray(direction, np.float64)
    basis = _basis(direction / np.linalg.norm(direction), np.asarray(up, np.float64))
    across, upright, toward = (
        basis @ (np.asarray(points, np.float64) - np.asarray(target, np.float64)).T
    )
    width, height = _size(size)
    slope_y = float(np.tan(np.radians(fov_y) / 2)) / margin
    needed = toward + np.maximum(np.abs(across) * height / width, np.abs(upright)) / slope_y
    return float(needed.max()) or 1.0  # a single point is seen from anywhere


def _in_the_middle(places: NDArray[np.float64], depth: NDArray[np.float64], start: float) -> float:
    """Where along an axis the eye sees as much of the points on one side as on the other; from `start`, which fits.

    Args:
        places: (n,) along the axis.
        depth: (n,) before the eye, positive.
        start: an eye that has all points in its image; where the search does not improve on it, it is returned.
    """
    eye, best, least = start, start, np.inf
    for _ in range(8):
        seen = (places - eye) / depth
        i, j = int(seen.argmax()), int(seen.argmin())
        if max(seen[i], -seen[j]) >= least:
            break
        best, least = eye, max(seen[i], -seen[j])
        eye = float((places[i] * depth[j] + places[j] * depth[i]) / (depth[i] + depth[j]))
    return best


def fit_box(
    low: ArrayLike,
    high: ArrayLike,
    direction: ArrayLike = (0.5, 0.35, 0.8),
    size: tuple[int, int] = TABLE_SIZE,
    fov_y: float = FOV_Y,
    margin: float = 1.06,
    up: ArrayLike = _AXES["y"],
) -> View:
    """The nearest view along `direction` that has all eight corners of a box in the image: see `fit_points`.

    Raises:
        ValueError: a value out of its range.
    """
    low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
    if low.shape != (3,) or high.shape != (3,) or not (low <= high).all():
        raise ValueError(f"low, high: expected two corners of a box, got {low} and {high}")
    corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T
    return fit_points(corners, direction, size, fov_y, margin, up)


def moved(view: View, by: ArrayLike) -> View:
    """The same picture of a world that is moved by (3,) model units, and the eye with it."""
    by = np.asarray(by, np.float64)
    back = np.eye(4)
    back[:3, 3] = -by
    return replace(view, eye=view.eye + by, world_to_clip=view.world_to_clip @ back)


def to_screen(view: View) -> NDArray[np.float32]:
    """World to fixed-point screen, (16,) float32: rows of x, y (sub-pixels, y down), depth 0..1 and w, times w.

    Of a world much larger or smaller than 1 all four times a power of two, which float32 needs and w takes out again.
    """
    m = view.world_to_clip
    rows = np.stack(
        [
            128.0 * view.width * (m[0] + m[3]),
            128.0 * view.height * (m[3] - m[1]),
            0.5 * (m[2] + m[3]),
            m[3],
        ]
    )
    shift = -int(np.frexp(np.abs(rows[:, 3]).max())[1])  # what is added is as large as the world
    if abs(shift) > ORDINARY:
        shift = min(shift + ROOM, FARTHEST - int(np.frexp(np.abs(rows).max())[1]))
        rows = np.ldexp(rows, shift)
    return rows.astype(np.float32).ravel()


def pixel_rows(view: View) -> tuple[Any, Any, Any]:
    """Four numbers each that bring (x, y, z, 1) to pixels times w, and to w."""
    clip = np.asarray(view.world_to_clip, np.float64)
    rows = clip[0] * view.width / 2, clip[1] * view.height / 2, clip[3]
    scale = max(float(np.abs(clip[3]).max()), 1e-37)
    x, y, w = (tuple((row / scale).tolist()) for row in rows)
    return x, y, w
