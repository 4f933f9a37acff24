"""How much detail a frame asks for: one threshold for all nodes, or a tolerance in pixels for each.

Lengths are in the tree's units: model units times its `scale`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lodbench.kernels.geometry_image.quadtree_lod.params import Params
from lodbench.kernels.system import View

if TYPE_CHECKING:
    from lodbench.kernels.geometry_image.quadtree_lod.tree import Tree

EPSILON32 = float(np.finfo(np.float32).eps)
SLACK = 16
"""Roundings of two distances in float32, each a few half units of the eye's distance; twice what they add up to."""
NEAREST = 1e-6  # of the diagonal; an eye inside a node's sphere sees it from here


@dataclass(frozen=True)
class LodCriterion:
    """What the filter compares errors with: one threshold, or each node's size on screen.

    Attributes:
        threshold: of a node's error.
        eye_scale: the eye, and pixels per unit at distance 1, per pixel of tolerance; a scale of 0 means one
            threshold for all nodes.
        near_slack: the smallest distance, and what a node's distance gains per depth so that rounding never breaks the
            order along a branch.
    """

    threshold: float = 0.0
    eye_scale: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    near_slack: tuple[float, float] = (0.0, 0.0)

    @property
    def per_node(self) -> bool:
        return self.eye_scale[3] != 0


def pixels_per_unit(view: View) -> tuple[float, bool]:
    """Pixels that a model unit covers, up and down the screen: at distance 1, and True; or at any, and False.

    The second is an orthographic view's.
    """
    up, depth = view.world_to_clip[1], view.world_to_clip[3]
    along = float(np.linalg.norm(depth[:3]))
    tall = float(np.linalg.norm(up[:3])) * view.height / 2
    return (tall / along, True) if along else (tall / abs(float(depth[3])), False)


def criterion_of(tree: Tree, params: Params, threshold: float, view: View | None) -> LodCriterion:
    """The detail for a frame: from its view, or `threshold` where there is none or it does not count.

    Source: Wang et al., section 3.2, step 3 (one threshold for the model, by the viewer's distance); the rule for
    nodes is a reconstruction.
    """
    if view is None or params.view == "none":
        return LodCriterion(at_most_float32(threshold))
    unit = tree.scale
    scale, perspective = pixels_per_unit(view)
    if not perspective:
        return LodCriterion(at_most_float32(params.pixels / scale * unit))
    diagonal = tree.diagonal * unit
    nearest = max(NEAREST * diagonal, float(np.finfo(np.float32).tiny))
    eye = np.asarray(view.eye, np.float64) * unit
    apart = float(np.linalg.norm(eye - (tree.low + tree.high) * unit / 2))
    if params.view == "global":
        away = max(apart - diagonal / 2, nearest)
        return LodCriterion(at_most_float32(params.pixels * away / scale))
    slack = SLACK * EPSILON32 * (apart + diagonal)
    x, y, z, w = (float(np.float32(v)) for v in (*eye, scale / params.pixels))
    return LodCriterion(0.0, (x, y, z, w), (float(np.float32(nearest)), float(np.float32(slack))))


def at_most_float32(value: float) -> float:
    """The value as float32, kept finite."""
    return float(np.float32(min(value, float(np.finfo(np.float32).max))))
