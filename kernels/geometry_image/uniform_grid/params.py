"""The parameters of drawing a geometry image at one detail."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from lodbench.kernels.geometry_image import quadtree_lod
from lodbench.kernels.geometry_image.parameterisation import Level, Seed, Turn
from lodbench.kernels.parameters import Range
from lodbench.kernels.targets import Target


@dataclass(frozen=True)
class Params(Target):
    """Which grid: `cells`, or the most, even, with at most as many triangles as a target says; 8 at the least.

    Attributes:
        n: the image made of a triangle mesh has (2^n + 1)^2 samples, 1 to 11; a geometry image brings its own.
        cells: cells along a side, even; None takes the image's own. The grid has 2 * cells^2 triangles.
        seed: of the layout on the sphere.
        turn: "best" or "identity", how the sphere is turned before it is unfolded.
        cache: keep the sphere on disk.
    """

    n: Level = 8
    cells: Annotated[int, Range(2)] | None = None
    seed: Seed = 0
    turn: Turn = "best"
    cache: bool = True

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.cells is not None and self.cells % 2:
            raise ValueError(f"cells: expected an even number, got {self.cells}")

    def layout(self) -> quadtree_lod.Params:
        """The parameters of making the image."""
        return quadtree_lod.Params(n=self.n, seed=self.seed, turn=self.turn, cache=self.cache)
