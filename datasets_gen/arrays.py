"""Arrays as surfaces keep them: checked by name, float32, about an origin where they lie far from zero."""

from __future__ import annotations

import struct
import tokenize
import zipfile
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

Origin = NDArray[np.float64]

FAR = 16.0
"""Extents of the box between zero and an axis' farthest coordinate above which the axis gets an origin: float32 has 24
bits of the coordinate, so that up to there 20 of the extent are left."""

BROKEN = (
    ValueError, TypeError, OSError, KeyError, EOFError, AttributeError, IndexError, NotImplementedError, RuntimeError,
    OverflowError, SyntaxError, MemoryError, struct.error, zlib.error, tokenize.TokenError, zipfile.BadZipFile,
)  # fmt: skip
"""What numpy raises where an .npy or .npz file is broken; MemoryError where its header promises terabytes."""


def checked_origin(origin: Any) -> Origin | None:
    """`origin` as read-only (3,) float64; None where it is None or zero.

    Raises:
        ValueError: another shape, NaN or infinity.
    """
    if origin is None:
        return None
    found = np.array(origin, np.float64)
    if found.shape != (3,) or not np.isfinite(found).all():
        raise ValueError(f"origin: expected 3 finite numbers, got {np.asarray(origin).tolist()}")
    found.flags.writeable = False
    return found if found.any() else None


def box(points: NDArray[np.number]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lower and upper corner of all points, (n, columns), as (columns,) float64 each; zeros when there are none.

    Column by column: over the first axis of so short rows numpy takes 25 times as long.
    """
    if not len(points):
        return np.zeros(points.shape[1]), np.zeros(points.shape[1])
    low, high = ([each(column) for column in points.T] for each in (np.min, np.max))
    return np.array(low, np.float64), np.array(high, np.float64)


def recentred(points: Any) -> tuple[Any, Origin | None]:
    """Points, (..., 3), about an origin in their middle on each axis that is `FAR`; or as they came, and None.

    What is float32 already has no more to lose and stays. The origin is a multiple of a power of two of the extent's
    size, so that numbers which float32 can hold, far or about the origin, come back to the bit.
    """
    given = np.asarray(points)
    if (
        given.dtype.kind not in "fiu"
        or np.can_cast(given.dtype, np.float32)
        or given.ndim < 2
        or given.shape[-1] != 3
        or not given.size
    ):
        return points, None
    origin = middle(*box(given.reshape(-1, 3)))
    return (points, None) if origin is None else (given.astype(np.float64) - origin, origin)


def middle(low: NDArray[np.float64], high: NDArray[np.float64]) -> Origin | None:
    """The origin of points in the box from `low` to `high`, (3,), see `recentred`; None where no axis is `FAR`."""
    with np.errstate(all="ignore"):  # NaN and overflow are not far
        extent = float((high - low).max())
        largest = np.maximum(np.abs(low), np.abs(high))
        far = (largest > FAR * extent) & (largest < np.inf)
        if not far.any():
            return None
        between = low / 2 + high / 2
        step = 2.0 ** np.floor(np.log2(extent)) if extent > 0 else 0.0
        rounded = np.round(between / step) * step
    origin = np.where(far, np.where(np.isfinite(rounded), rounded, between), 0.0)
    return checked_origin(origin)


def rows(argument: str, values: object, dtype: type, columns: int, count: int | None = None):
    """`values` as a read-only C-contiguous (rows, columns) array of `dtype`, or an error by name."""
    array = np.asarray(values)

    def expected() -> str:
        return f"({'n' if count is None else count}, {columns}) {np.dtype(dtype).name}"

    if array.size == 0 and array.ndim != 2:
        array = array.reshape(0, columns)
    if array.ndim != 2 or array.shape[1] != columns or (count is not None and len(array) != count):
        raise ValueError(f"{argument}: expected {expected()}, got shape {array.shape}")
    wanted = "fiu" if np.dtype(dtype).kind == "f" else "iu"
    if array.size and array.dtype.kind not in wanted:
        raise TypeError(f"{argument}: expected {expected()}, got dtype {array.dtype}")
    array = (
        array.view()
        if array.dtype == dtype and array.flags.c_contiguous
        else np.array(array, dtype, order="C")
    )
    array.flags.writeable = False
    return array


def finite(argument: str, given: object, array: NDArray[np.floating]) -> None:
    if np.isfinite(array).all():
        return
    row = int(np.argmin(np.isfinite(array).all(axis=tuple(range(1, array.ndim)))))
    value = np.asarray(given)[row].tolist()
    raise ValueError(f"{argument}: expected finite float32 values, got {value} in row {row}")


def area_normals(
    positions: NDArray[np.float32], triangles: NDArray[np.uint32], shared: bool = False
) -> NDArray[np.float32]:
    """Unit normals of vertices, (n, 3), weighted by the area of their triangles; (0, 0, 1) where there is none.

    Args:
        positions: (n, 3).
        triangles: (m, 3).
        shared: sum over all vertices at a place, which are parted for another reason than a hard edge.
    """
    low, high = box(positions)
    extent = float((high - low).max())
    scale = max(extent, float(np.finfo(np.float32).tiny))
    corners = ((positions.astype(np.float64) - low) / scale)[triangles]
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    place, count = triangles.ravel(), len(positions)
    if shared and count:
        _, same = np.unique(positions + np.float32(0), axis=0, return_inverse=True)
        same = same.ravel()
        place = same[place]
    total = np.stack([np.bincount(place, np.repeat(k, 3), count) for k in face.T], axis=1)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    unit = np.where(length > 0, total / np.where(length > 0, length, 1), (0.0, 0.0, 1.0))
    return (unit[same] if shared and count else unit).astype(np.float32)


def usable(values: Any, count: int, columns: int) -> NDArray[np.floating] | None:
    """Attributes as another library has them, (count, columns) at least; None where there are none, or not finite."""
    if values is None:
        return None
    found = np.asarray(values)
    if found.dtype.kind not in "fiu" or found.ndim != 2 or len(found) != count:
        return None
    found = found[:, :columns].astype(np.float64)
    with np.errstate(over="ignore"):
        good = found.shape[1] == columns and np.isfinite(found.astype(np.float32)).all()
    return found if good else None
