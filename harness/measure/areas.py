"""How much of a surface each vertex stands for."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh


@lru_cache(maxsize=1)
def vertex_areas(mesh: TriangleMesh) -> NDArray[np.float64]:
    """Twice the area of the triangles at each vertex, (n,), model units squared; that of the last mesh is kept."""
    a, b, c = (mesh.positions[corner].astype(np.float64) for corner in mesh.triangles.T)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    found = [np.bincount(corner, areas, mesh.vertex_count) for corner in mesh.triangles.T]
    return np.sum(found, axis=0)
