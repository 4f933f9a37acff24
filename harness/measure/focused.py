"""How good a result is where it is looked at, and elsewhere: around a place, or in pixels as an eye sees it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.measure.quality import located
from lodbench.harness.plan.focus import Focus
from lodbench.kernels.system import View

Doubles = NDArray[np.float64]


def measure(
    reference: TriangleMesh,
    result: TriangleMesh,
    focus: Focus,
    seed: int = 0,
    *,
    samples: int = 100_000,
) -> dict[str, float | int | None]:
    """Errors and triangles inside of the focus and outside.

    Args:
        reference: the input; distances are fractions of its bounding-box diagonal.
        result: what was made of it.
        focus: the ball; or the eye, whose inside is what its image has room for, hidden or not.
        seed: of the samples: same seed, same figures.
        samples: points of the reference, spread by area.

    Returns:
        `triangles_inside` and `triangles_outside`, by their centroids, and `rms_error_inside` and
        `rms_error_outside`, from the reference to the result. Of an eye also `rms_pixels`, the root of the mean squared
        distance over the depth, in pixels, of what is inside, each sample as often as it covers pixels, by its depth
        alone; and of that `rms_pixels_near` and `rms_pixels_far`, the half that is nearer to the eye than the median
        sample and the other. None of what there is none of.

    Raises:
        Unsupported: libigl is not installed.
    """
    if not reference.triangle_count or not result.triangle_count:
        return {}
    there, here = located(reference), located(result, reference)
    points = there.samples(samples, np.random.default_rng(seed))
    squared, _ = here.nearest(points)
    low, scale = reference.box[0].astype(np.float64), reference.diagonal or 1.0
    centroids = here.positions[here.triangles].mean(axis=1) * scale + low
    points = points * scale + low
    view = None if focus.radius else focus.view(reference)
    if view is None:
        middle, radius = np.asarray(focus.place(reference)), focus.radius * scale
        inside, within = (
            np.linalg.norm(some - middle, axis=1) <= radius for some in (points, centroids)
        )
    else:
        inside, within = _seen(view, points)[0], _seen(view, centroids)[0]
    found: dict[str, float | int | None] = {
        "triangles_inside": int(within.sum()),
        "triangles_outside": int((~within).sum()),
        "rms_error_inside": _rms(squared[inside]),
        "rms_error_outside": _rms(squared[~inside]),
    }
    if view is None:
        return found
    depth = _seen(view, points)[1][inside]
    focal = float(np.linalg.norm(view.world_to_clip[1, :3])) * view.height / 2
    pixels = squared[inside] * (scale * focal / depth) ** 2
    near = depth <= np.median(depth) if len(depth) else np.zeros(0, bool)
    covers = 1 / depth**2
    return found | {
        "rms_pixels": _rms(pixels, covers),
        "rms_pixels_near": _rms(pixels[near], covers[near]),
        "rms_pixels_far": _rms(pixels[~near], covers[~near]),
    }


def _rms(squared: Doubles, weights: Doubles | None = None) -> float | None:
    return float(np.sqrt(np.average(squared, weights=weights))) if len(squared) else None


def _seen(view: View, points: Doubles) -> tuple[NDArray[np.bool_], Doubles]:
    """Which points are in the view, and how deep all are."""
    clip = points @ view.world_to_clip[:, :3].T + view.world_to_clip[:, 3]
    depth = clip[:, 3]
    return (depth > 0) & (np.abs(clip[:, :3]) <= depth[:, None]).all(1), depth
