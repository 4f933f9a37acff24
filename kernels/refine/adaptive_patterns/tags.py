"""What depth tags are made of: what the kernel reads of each vertex, and its measures of a frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Floats, TriangleMesh
from lodbench.kernels.refine.adaptive_patterns.params import Params
from lodbench.kernels.system import View

KINDS = {"given": 0, "distance": 1, "screen": 2, "curvature": 3, "mixed": 4}  # BY of tags.cl


def spans(mesh: TriangleMesh, diagonal: float) -> Floats:
    """Of each vertex the mean length of the edges around it, and the height of the highest arc over one.

    The arc is that of a curved PN triangle: its middle lies over the chord by a quarter of the distance by which an
    end lies over the other's tangent plane. Tags by its height are a reconstruction.

    Args:
        mesh: with normals.
        diagonal: of its box, model units.

    Returns:
        (n, 2) float32 in diagonals.
    """
    corners = mesh.triangles.astype(np.int64)
    ends = np.concatenate([corners, np.roll(corners, -1, axis=1)]).reshape(2, -1)
    points = mesh.positions.astype(np.float64) / diagonal
    normals = np.asarray(mesh.normals, np.float64).reshape(-1, 3)
    edge = points[ends[1]] - points[ends[0]]
    length = np.linalg.norm(edge, axis=1)
    over = np.maximum(*(np.abs((edge * normals[end]).sum(axis=1)) for end in ends)) / 4
    found = np.zeros((mesh.vertex_count, 2))
    every, both = ends.ravel(), np.concatenate([length, length])
    around = np.bincount(every, minlength=mesh.vertex_count)
    found[:, 0] = np.bincount(every, both, mesh.vertex_count) / np.maximum(around, 1)
    np.maximum.at(found[:, 1], every, np.concatenate([over, over]))
    return found.astype(np.float32)


def pixels_per_unit(view: View) -> float:
    """Pixels that a model unit at distance 1 takes."""
    clip = view.world_to_clip
    return float(view.height / 2 * np.linalg.norm(clip[1, :3]) / np.linalg.norm(clip[3, :3]))


def measures(
    params: Params, view: View | None, diagonal: float
) -> tuple[tuple[float, float, float, float], tuple[float, float, float, float]]:
    """The kernel's `eye` and `measure` for a frame; without a view nothing is far."""
    x, y, z = (0.0, 0.0, 0.0) if view is None else map(float, view.eye)
    scale = 0.0 if view is None else pixels_per_unit(view) / params.pixels
    return (x, y, z, params.near), (
        scale, 1 / params.tolerance, float(view is not None), 1 / diagonal,
    )  # fmt: skip


def expected_tags(
    params: Params,
    positions: Floats,
    span: Floats,
    view: View | None,
    diagonal: float,
) -> NDArray[np.float64]:
    """The tags of a frame in float64, (n,), 0 to the finest depth; of "given" ones there is nothing to expect."""
    finest = float(params.finest)
    (x, y, z, near), (scale, per_tolerance, seen, inverse) = measures(params, view, diagonal)
    away = np.linalg.norm((positions.astype(np.float64) - (x, y, z)) * inverse, axis=1)
    with np.errstate(divide="ignore"):
        length, height = span.astype(np.float64).T
        screen = np.log2(length / np.maximum(away, 1e-18) * scale) if seen else finest
        curvature = np.log2(height * per_tolerance) / 2
        distance = finest - np.log2(np.maximum(away / near, 1)) if seen else finest
    found = {
        "distance": distance, "screen": screen, "curvature": curvature,
        "mixed": np.minimum(screen, curvature),
    }[params.by]  # fmt: skip
    return np.clip(np.broadcast_to(found, away.shape), 0, finest)
