"""The parameters of drawing a geometry image from its quadtree."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from lodbench.kernels.geometry_image.parameterisation import Level, Mode, Seed, Turn
from lodbench.kernels.parameters import Range
from lodbench.kernels.targets import Target


@dataclass(frozen=True)
class Params(Target):
    """How much detail; a target, counted in the triangles of what is given, replaces `threshold`.

    The smallest threshold with at most so many triangles is searched; never fewer than 8 are drawn.

    Attributes:
        n: the image made of a triangle mesh has (2^n + 1)^2 samples, 1 to 11; a geometry image brings its own.
        threshold: largest error of a drawn node where the frame has no view, as a fraction of the bounding-box
            diagonal; 0 draws every leaf.
        pixels: largest error on screen where the frame has a view.
        view: "global", one distance for the whole model, as in the paper; "node", each node's own; "none", views are
            ignored.
        placement: "samples", vertices lie on the image's samples, as in the paper; "fitted", where they fit the full
            image best at their own level (an addition; about two thirds of the error at the same count).
        error_metric: what a node's error is: "distance", the largest of its samples from its triangles, which a
            tolerance in pixels needs; "rms_share", its share of the surface's root mean square error, which gives the
            smallest such error for a number of triangles.
        mode: how a triangle mesh is laid out on the sphere, see `parameterisation`.
        seed: of what is random in that.
        turn: "best" or "identity", how the sphere is turned before it is unfolded.
        cache: keep the sphere on disk.
    """

    n: Level = 8
    threshold: Annotated[float, Range(0)] = 0.001
    pixels: Annotated[float, Range(0, open="low")] = 1.0
    view: Literal["global", "node", "none"] = "global"
    placement: Literal["samples", "fitted"] = "samples"
    error_metric: Literal["distance", "rms_share"] = "distance"
    mode: Mode = "coarse_to_fine"
    seed: Seed = 0
    turn: Turn = "best"
    cache: bool = True
