"""Vertex shader tessellation in float64: the map, then each patch at all of its virtual vertices."""

from __future__ import annotations

from lodbench.kernels.bezier.lattice import lattice_parameters
from lodbench.kernels.bezier.reference import Doubles, normals_at, points_at


def tessellated(P: Doubles, level: int) -> tuple[Doubles, Doubles]:
    """Points and unit normals of patches, (m, 4, 4, 3), at the (2^level + 1)^2 virtual vertices: (m, n, 3) each."""
    u, v = lattice_parameters(level)
    return points_at(P, u, v), normals_at(P, u, v)[0]
