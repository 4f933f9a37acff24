"""Is the map onto the sphere one to one? Signed areas and turned-over triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.geometry_image.parameterisation.hierarchy import Faces, Points

AREA_TOLERANCE = 1e-6
"""Of the covering degree: the sum of a hundred thousand rounded angles, far below the 1 of a second sheet."""


def determinants(sphere: Points, faces: Faces) -> NDArray[np.float64]:
    """det(a, b - a, c - a) of each triangle: positive where it faces outward. The difference form does not cancel."""
    a, b, c = (sphere[faces[:, k]] for k in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b - a, c - a))


def flipped(sphere: Points, faces: Faces) -> NDArray[np.int64]:
    """Triangles that are turned over or have no area on the sphere."""
    return np.flatnonzero(~(determinants(sphere, faces) > 0))


def signed_areas(sphere: Points, faces: Faces) -> NDArray[np.float64]:
    """Signed spherical area of each triangle.

    Source: Van Oosterom & Strackee 1983.
    """
    a, b, c = (sphere[faces[:, k]] for k in range(3))
    below = (
        1 + np.einsum("ij,ij->i", a, b) + np.einsum("ij,ij->i", b, c) + np.einsum("ij,ij->i", c, a)
    )
    return 2 * np.arctan2(determinants(sphere, faces), below)


def degree(sphere: Points, faces: Faces) -> float:
    """How many times the sphere is covered; 1 with no flipped triangle means one to one."""
    return float(signed_areas(sphere, faces).sum() / (4 * np.pi))
