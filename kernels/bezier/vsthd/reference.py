"""The same surface as vertex shader tessellation, and what a draw of it needs on a handheld device."""

from __future__ import annotations

from lodbench.kernels.bezier.lattice import side_vertices
from lodbench.kernels.bezier.vst.reference import tessellated

__all__ = ["draws", "map_bytes", "tessellated", "uniform_vectors"]


def draws(patches: int, surfaces_per_draw: int) -> int:
    """NDP of the thesis's table 5.3."""
    return -(-patches // surfaces_per_draw)


def map_bytes(level: int, surfaces_per_draw: int) -> int:
    """Of the vertex buffer: u, v and the patch's number of every vertex of a draw (table 5.2)."""
    return 12 * surfaces_per_draw * side_vertices(level) ** 2


def uniform_vectors(surfaces_per_draw: int) -> int:
    """Vectors of four that a draw has in uniforms: 16 of each patch, four of a matrix."""
    return 16 * surfaces_per_draw + 4
