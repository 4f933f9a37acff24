"""Factors, segments and where they end, in float64."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.bezier.reference import Doubles


def cut(factor: NDArray[np.floating], spacing: str) -> tuple[Doubles, NDArray[np.int64]]:
    """The factor that counts and the segments that it gives, for each factor.

    Source: OpenGL 4.0 specification, section 2.12: clamped to what the spacing allows, rounded up to a whole, odd or
    even number.
    """
    used = np.maximum(factor, 2.0 if spacing == "even" else 1.0).astype(np.float64)
    whole = np.ceil(used).astype(np.int64)
    if spacing == "integer":
        return whole.astype(np.float64), whole
    return used, whole + (whole % 2 == (spacing == "even"))


def place(k: NDArray[np.int64], factor: float, segments: int) -> Doubles:
    """Where segment ends lie along a side, 0..1: all but the first and the last segment have length 1 / factor."""
    m = np.minimum(k, segments - k)
    t = np.where(m > 0, (m + 0.5 * (factor - segments)) / factor, 0.0)
    t = np.where(2 * m == segments, 0.5, t)
    return np.where(2 * k > segments, 1 - t, t)


def snapped(segments: int, own: int) -> NDArray[np.int64]:
    """For each vertex along a side of the inside's grid, the vertex of the edge that it comes to, which has fewer."""
    return (np.arange(segments + 1) * own + segments // 2) // segments


def polygon_lengths(points: Doubles) -> Doubles:
    """Of the control polygon of each edge, (m, 4), the same from either end: edges u = 0, u = 1, v = 0, v = 1."""
    edges = np.stack([points[:, 0], points[:, 3], points[:, :, 0], points[:, :, 3]], axis=1)
    a, b, c = np.moveaxis(np.linalg.norm(np.diff(edges, axis=2), axis=-1), -1, 0)
    return (a + c) + b
