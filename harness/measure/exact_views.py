"""Figures of NURBS surfaces as they are seen: what culling loses, and whether borders that are shared are joined."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from lodbench.datasets_gen.nurbs_surface import NurbsModel
from lodbench.harness.measure.exact_bezier import near, open_edges
from lodbench.harness.measure.figure import Figure, Seen
from lodbench.kernels.nurbs.borders import borders_of
from lodbench.kernels.nurbs.reference import points_at
from lodbench.kernels.nurbs.samples import by_span
from lodbench.kernels.opencl import Device
from lodbench.kernels.stages.camera import look_at
from lodbench.kernels.stages.raster import Raster
from lodbench.kernels.stages.shading import Shading
from lodbench.kernels.system import Frame, View, run

Doubles = NDArray[np.float64]

VIEWS = 5
SIZE = (1280, 1024)  # pixels, in which holes are looked for
SMALL = (640, 512)  # for which surfaces are cut whose edges are counted
FINE_AREA = 0.2  # pixels of a KSDice: a picture without holes
LOUD = (1.0, 0.0, 1.0)
STEPS = 64  # of each span of a border, at which its places are known
AT_RIM = 1e-3  # of the diagonal: so near the borders of one surface are both ends of an edge that may be open
BESIDE = 1 / 80  # of the image's width, from a border that surfaces do not share, which may be open


@lru_cache(maxsize=2)  # subjects of a group have the model, and what is visible of it, in common
def around(model: NurbsModel, count: int = VIEWS) -> tuple[View, ...]:
    """Views of a model's box from random directions, near and far in turn."""
    low, high = model.box
    middle, size = (low + high) / 2, max(np.linalg.norm(high - low), 1e-9)
    random = np.random.default_rng(count)
    ways = random.normal(size=(count, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    return tuple(
        look_at(middle + way * size * (0.7, 2.0)[k % 2], middle) for k, way in enumerate(ways)
    )


def lost(seen: Seen) -> Figure:
    """The share of samples in view that face the eye and whose KSQuads are culled; certified culling may lose none."""
    subject: Any = seen.prepared
    shares, culled = [], 0
    for view in around(seen.surface):
        run(seen.device, subject, Frame(view))
        gone, _, share = subject.lost()
        culled += gone
        shares.append(share)
    limit = 0 if seen.params.culling == "certified" else None
    return Figure(float(np.mean(shares)), limit, f"{culled:,} KSQuads culled in {VIEWS} views")


def seams(seen: Seen) -> Figure:
    """Edges of triangles that no other has, to the bit, but for those along borders of one surface alone; edges that
    are watertight may have none.
    """
    _, alone = shared_curves(seen.surface)
    rim, distance = KDTree(alone), AT_RIM * seen.surface.diagonal
    inside = at_rim = 0
    for view in around(seen.surface):
        view = replace(view, width=SMALL[0], height=SMALL[1])
        run(seen.device, seen.prepared, Frame(view))
        ends = open_edges(seen.prepared.result()[0])
        allowed = near(ends, rim, distance)
        at_rim += int(allowed.sum())
        inside += int((~allowed).sum())
    limit = 0 if seen.params.edges == "watertight" else None
    return Figure(inside, limit, f"{at_rim:,} more at open borders, {VIEWS} views")


def holes(seen: Seen) -> Figure:
    """Pixels at borders that surfaces share where the background shows, though the model is there; edges that are
    watertight may have none.
    """
    found = looked_at = 0
    fine = replace(seen.params, pixel_area=FINE_AREA, edges="watertight")
    for view, places in border_pixels(seen.device, seen.surface, type(seen.prepared), fine):
        found += holes_at(seen.device, seen.prepared, view, places)
        looked_at += len(places)
    limit = 0 if seen.params.edges == "watertight" else None
    return Figure(found, limit, f"{looked_at:,} pixels of borders in {VIEWS} views")


def holes_at(device: Device, prepared: Any, view: View, places: NDArray[np.int64]) -> int:
    """How many pixels around places, (n, 2), show the background."""
    image = _background(device, prepared, view)
    x, y = places.T
    shows = [image[y + j, x + i] for i in (-1, 0, 1) for j in (-1, 0, 1)]
    return int(np.sum(shows))


@lru_cache(maxsize=1)  # subjects of a group have the model in common
def border_pixels(
    device: Device,
    model: NurbsModel,
    kind: Callable[..., Any],
    params: Any,
    count: int = VIEWS,
    size: tuple[int, int] = SIZE,
) -> list[tuple[View, NDArray[np.int64]]]:
    """Some views, and the pixels in each where a border that surfaces share lies within the model, (n, 2): cut very
    fine, by a subject of this kind and params, it shows no background near them. Pixels near other borders are left
    out.
    """
    fine = kind(device, model, params)
    shared, alone = shared_curves(model)
    found = []
    for view in around(model, count):
        view = replace(view, width=size[0], height=size[1])
        run(device, fine, Frame(view))
        at = _pixels(view, shared)
        at = at[~_near(at, _pixels(view, alone), BESIDE * size[0])]
        inside = ((at >= 2) & (at < np.array(size) - 2)).all(axis=1)
        x, y = at[inside].T
        image = _background(device, fine, view)
        empty = np.any([image[y + j, x + i] for i in (-2, 0, 2) for j in (-2, 0, 2)], axis=0)
        found.append((view, at[inside][~empty]))
    return found


def _background(device: Device, prepared: Any, view: View) -> NDArray[np.bool_]:
    """Where a frame shows its background, (height, width)."""
    run(device, prepared, Frame(view))
    shading = Shading(background=(LOUD, LOUD))
    raster = Raster(device, prepared.output, view.width, view.height, shading, view=view)
    run(device, prepared, Frame(view), raster)
    return raster.keys()[0] == 1


def shared_curves(model: NurbsModel) -> tuple[Doubles, Doubles]:
    """Points along borders that surfaces share, and along those of one alone, (n, 3) each."""
    none = np.zeros((0, 3))
    found: dict[bool, list[Doubles]] = {True: [none], False: [none]}
    borders = borders_of(model)
    uses = np.bincount(borders.owner.ravel(), minlength=borders.owner.size)
    for s, surface in enumerate(model.surfaces):
        u, v = (by_span(knots, STEPS) for knots in (surface.knots_u, surface.knots_v))
        for e in range(4):
            ends = (u.ends(e == 1), v) if e < 2 else (u, v.ends(e == 3))
            shared = uses[borders.owner[s, e]] > 1 or borders.collapsed[s, e]
            found[bool(shared)].append(points_at(surface, *ends).reshape(-1, 3))
    return np.concatenate(found[True]), np.concatenate(found[False])


def _pixels(view: View, points: Doubles) -> NDArray[np.int64]:
    """Where points are in the image, (n, 2) whole numbers; far away what is behind the eye."""
    x, y, _, w = view.world_to_clip @ np.column_stack([points, np.ones(len(points))]).T
    w = np.where(w > 0, w, 1e-9)
    at = np.stack([(1 + x / w) * view.width / 2, (1 - y / w) * view.height / 2], axis=1)
    return np.unique(np.clip(at, -1e6, 1e6).astype(np.int64), axis=0)


def _near(points: NDArray[np.int64], others: NDArray[np.int64], away: float) -> NDArray[np.bool_]:
    """Is one of the others so near in the image?"""
    if not len(others) or not len(points):
        return np.zeros(len(points), np.bool_)
    return KDTree(others).query(points)[0] <= away
