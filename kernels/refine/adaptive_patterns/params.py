"""The parameters of adaptive patterns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from lodbench.kernels.parameters import Range
from lodbench.kernels.refine.params import RefineParams, SurfaceOptions

MOST = 128  # segments: a pool eight times as large for every doubling


@dataclass(frozen=True)
class Params(SurfaceOptions, RefineParams):
    """What asks for how much, up to `segments`, a power of two of at most 128.

    Attributes:
        surface: "flat", the triangles themselves; "pn_triangles" or "st_triangles", as those systems have them.
        by: what a vertex's depth tag follows: "curvature", until arcs are lower than `tolerance`; "distance", a level
            less for each doubling of the eye's distance past `near`; "screen", until segments are shorter than
            `pixels`; "mixed", the lesser of curvature and screen; or "given", `depths` that come with the mesh.
        tolerance: height of an arc over its segment that curvature allows, as a fraction of the bounding-box diagonal.
        pixels: length of a segment that the screen allows.
        near: distance of the eye from a vertex, in diagonals, up to which it is finest.
        geomorphing: let vertices of the finest level come out of the middle of their edge, in place of popping.
        indices: write a list of all triangles, which drawing needs.
    """

    surface: Literal["flat", "pn_triangles", "st_triangles"] = "pn_triangles"
    by: Literal["curvature", "distance", "screen", "mixed", "given"] = "curvature"
    tolerance: Annotated[float, Range(0, open="low")] = 1e-4
    pixels: Annotated[float, Range(0, open="low")] = 8.0
    near: Annotated[float, Range(0, open="low")] = 1.0
    geomorphing: bool = False
    indices: bool = True

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.segments > MOST or self.segments & (self.segments - 1):
            raise ValueError(f"segments: expected a power of two up to {MOST}, got {self.segments}")

    @property
    def finest(self) -> int:
        """The largest depth: segments is two to its power."""
        return self.segments.bit_length() - 1
