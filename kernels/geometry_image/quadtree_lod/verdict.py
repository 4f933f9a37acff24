"""Is the last frame what the reference draws at the same detail?"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lodbench.kernels.geometry_image.quadtree_lod.reference import (
    fine_nodes,
    merge,
    node_errors,
    node_states,
)
from lodbench.kernels.system import Check

if TYPE_CHECKING:
    from lodbench.kernels.geometry_image.quadtree_lod.host import QuadtreeLod

ERROR_TOLERANCE = 4e-6
"""A node's error in float32 against float64, of the diagonal: the difference of two points and their interpolation."""


def verdict(prepared: QuadtreeLod) -> Check:
    """Share of output values that differ from the reference; the tree's errors must be right first."""
    what = "vertices and triangles that differ from the reference"
    mesh = prepared.result()[0]
    image = prepared.image
    if image is None:
        return Check(mesh.triangle_count == 0, what, float(mesh.triangle_count), 0.0)
    errors = prepared.tree.read_errors()
    exact = node_errors(prepared.tree.scaled_places(), prepared.tree.per_area)
    scale = prepared.tree.diagonal * prepared.tree.scale or 1.0
    wrong = max(float(np.abs(a - b).max()) for a, b in zip(errors[1:], exact[1:], strict=True))
    if wrong > ERROR_TOLERANCE * scale:
        text = "largest deviation of a node's error, of the diagonal"
        return Check(False, text, wrong / scale, ERROR_TOLERANCE)
    assert prepared.last is not None
    fine = fine_nodes(errors, prepared.tree.read_bounds(), prepared.last)
    fitted = prepared.params.placement == "fitted"
    expected = merge(image, node_states(fine), prepared.tree.places if fitted else None)
    same = (
        mesh.positions.shape == expected.positions.shape
        and mesh.triangles.shape == expected.triangles.shape
    )
    differing = (
        float(
            (mesh.positions != expected.positions).any(axis=1).sum()
            + (mesh.triangles != expected.triangles).any(axis=1).sum()
        )
        if same
        else float(abs(mesh.triangle_count - expected.triangle_count) or 1)
    )
    return Check(differing == 0, what, differing, 0.0)
