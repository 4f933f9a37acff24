"""Were these the vertices and triangles of an adaptive tessellation? Against float64 and the readable forms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import BezierPatches, TriangleMesh
from lodbench.kernels.bezier.adaptive_params import AdaptiveParams
from lodbench.kernels.bezier.candidates import (
    DEEPEST,
    NODES,
    Flags,
    Integers,
    Masks,
    cell_samples,
    nodes_of,
    ways_of,
)
from lodbench.kernels.bezier.grids import (
    FIRST_HALF,
    Wish,
    cell_bends,
    edges_of,
    grid_costs,
    grid_masks,
)
from lodbench.kernels.bezier.half_strips import half_strips
from lodbench.kernels.bezier.lattice import lattice_parameters, side_vertices
from lodbench.kernels.bezier.measures import (
    SCREEN,
    inverse_diagonal,
    measured,
    passes,
    screen_rows,
    way_bends,
)
from lodbench.kernels.bezier.reference import Doubles, normals_at, points_at
from lodbench.kernels.bezier.rises import MOST, UNITS, half_rises, place_rises
from lodbench.kernels.bezier.strips import strips
from lodbench.kernels.bezier.tessellated import CHECKED
from lodbench.kernels.exactness import NORMAL_LIMIT, POSITION_LIMIT, verdict
from lodbench.kernels.system import Check, View

NODE_BITS = (1 << NODES) - 1
CERTAIN = 1e-3
"""A measure that is nearer to the threshold than this share of it may fall to either side in float32; so may one within
what the roundings of points come to."""
ROUNDING = {"distance": 4e-6, "flat": 4e-6, "length": 1e-4 * SCREEN, "mean": 4e-6}
ROUNDED_AREA = 1e-7  # what the area of a line comes to in float32, in squares of the diagonal
Inserted = Callable[[Flags, Flags, int], Flags]


@dataclass(frozen=True, eq=False)
class Wished:
    """What was chosen by the test "mean": each cell's wish and its halves' rises, rings of edges and of corners, those
    that stay on the surface, and the area of all.
    """

    wishes: Integers
    rises: Integers
    ring: NDArray[np.uint32]
    corner_ring: NDArray[np.uint32]
    held: NDArray[np.uint32]
    area: float


def judged(
    patches: BezierPatches,
    params: AdaptiveParams,
    view: View | None,
    mesh: TriangleMesh,
    masks: Masks,
    where: tuple[Integers, Integers],
    expected: Inserted | Wished,
) -> Check:
    """Some patches, spread over all, are compared.

    Args:
        patches: that were tessellated.
        params: by which.
        view: of the frame.
        mesh: what came out.
        masks: (m, cells, 2) nodes and way of each coarse triangle.
        where: patch and virtual vertex of each vertex.
        expected: which nodes a coarse triangle has, of those that pass; or what was wished for.
    """
    count = len(patches.points)
    some = np.unique(np.linspace(0, max(count - 1, 0), min(CHECKED, count)).astype(np.int64))
    P = patches.points[some].astype(np.float64)
    patch, place = where
    taken = np.isin(patch, some)
    own = np.searchsorted(some, patch[taken])
    u, v = lattice_parameters(params.base + DEEPEST)
    inverse = inverse_diagonal(patches.points)
    if isinstance(expected, Wished):
        wrong = _wrong_grids(P, params, inverse, masks, some, expected)
    else:
        wrong = _wrong_masks(P, params, inverse, view, masks[some], expected)
    wrong += _wrong_triangles(mesh, masks)
    box = patches.points.reshape(-1, 3).astype(np.float64)
    size = max(np.linalg.norm(np.ptp(box, axis=0)), np.abs(box).max()) if len(box) else 1.0
    points = points_at(P, u, v)[own, place[taken]]
    normals, certain = (a[own, place[taken]] for a in normals_at(P, u, v))
    limit = np.full(len(points), max(size, 1e-37) * POSITION_LIMIT)
    if isinstance(expected, Wished) and params.rises:
        rise = _rises(params, expected)[patch[taken], place[taken]] / inverse
        points += rise[:, None] * np.where(certain[:, None], normals, 0)
        limit += np.abs(rise) * np.where(certain, NORMAL_LIMIT, 1)
    off = np.abs(mesh.positions[taken] - points).max(axis=1)
    share = POSITION_LIMIT * (off / limit).max(initial=0)
    turned = 0.0
    if mesh.normals is not None:
        apart = np.linalg.norm(mesh.normals[taken] - normals, axis=-1)
        turned = apart[certain].max(initial=0)
    seen = f"or coarse triangles with wrong vertices or triangles, {len(some)} of {count} patches"
    return verdict(share, turned, seen, wrong)


def _wrong_masks(
    P: Doubles,
    params: AdaptiveParams,
    inverse: float,
    view: View | None,
    masks: Masks,
    inserted: Inserted,
) -> int:
    """Coarse triangles of a wrong way, or that insert what cannot pass or leave out what must; 2 for each."""
    measures = measured(P, params, inverse, screen_rows(view, inverse))
    ways, rounding = ways_of(masks), ROUNDING[params.test]
    own, others = _bends(way_bends(measures), ways)
    wrong = (own > others * (1 + CERTAIN) + rounding).any(axis=-1)
    margin = CERTAIN * params.least + rounding if params.least else 0.0
    low, high = (
        inserted(*passes(measures, ways, params.least + side), params.finest_depth)
        for side in (margin, -margin)
    )
    found = nodes_of(masks)
    wrong |= ((low & ~found) | (found & ~high)).any(axis=-1)
    return 2 * int(wrong.sum())


def _wrong_grids(
    P: Doubles,
    params: AdaptiveParams,
    inverse: float,
    masks: Masks,
    some: Integers,
    asked: Wished,
) -> int:
    """Cells of some patches that wish for more than the cheapest grid, and of all whose masks do not follow; 2 each."""
    wrong = (
        grid_masks(asked.wishes, edges_of(asked.wishes, asked.ring)) != masks.reshape(-1, 2)
    ).any(axis=-1)
    price = params.least * asked.area
    bends = cell_bends(P, params.base, inverse)
    whole, halves, areas = grid_costs(bends, price, params.rises)
    own = Wish.of(asked.wishes.reshape(masks.shape[:2])[some].ravel())
    depth = params.finest_depth
    halves = halves[..., :depth, : depth + 1].reshape(
        whole.size // 2, *halves.shape[2:5], depth, depth + 1
    )
    least = [whole.min(-1).ravel()]
    if depth:
        least += list(halves.min((3, 4, 5)).sum(2).T)
    cell = np.arange(len(own.cut))
    costs = [np.take_along_axis(whole.reshape(-1, 2), own.other[:, :1], 1)[:, 0]]
    for cut in (0, 1) if depth else ():
        of_half = [
            halves[cell, cut, k, own.other[:, k], own.rows[:, k], own.columns[:, k]] for k in (0, 1)
        ]
        costs.append(of_half[0] + of_half[1])
    margin = ROUNDING["mean"] * (areas.ravel() + ROUNDED_AREA)
    dear = np.choose(own.cut, costs) > np.min(least, axis=0) * (1 + CERTAIN) + margin
    if not price:  # whatever bends
        dear = (own.cut == 0) | (own.rows != depth - 1).any(1) | (own.columns != depth).any(1)
        dear &= depth > 0
    rises = asked.rises.reshape(*masks.shape[:2], 2)[some].reshape(-1, 2)
    exact = np.clip(half_rises(bends, own), -MOST / UNITS, MOST / UNITS)
    size = areas.ravel()[:, None]
    allowed = ROUNDING["mean"] * (size + ROUNDED_AREA) + CERTAIN * np.abs(exact) * size
    risen = np.abs(rises / UNITS - exact) * size > allowed
    return 2 * int(wrong.sum() + dear.sum() + risen.any(axis=1).sum())


def _rises(params: AdaptiveParams, asked: Wished) -> Doubles:
    """How far every virtual vertex rises, (m, vertices), in diagonals."""
    rings = asked.ring.astype(np.int64), asked.corner_ring.astype(np.int64)
    of_cells = place_rises(asked.wishes, asked.rises, rings, asked.held.astype(np.int64))
    level = params.base + DEEPEST
    found = np.zeros((len(of_cells) // 4**params.base, side_vertices(level) ** 2))
    samples = int(np.prod(of_cells.shape[1:]))
    found[:, cell_samples(level)] = of_cells.reshape(len(found), 4**params.base, samples)
    return found


def _bends(bends: Doubles, ways: Integers) -> tuple[Doubles, Doubles]:
    """Of base and diagonal, (m, cells, 2, 2) each: as chosen, and the least that there were to choose from."""
    own = np.take_along_axis(bends, ways[..., None], axis=2)
    turns = 3 * (ways // 3)[..., None] + np.arange(3)
    bases = np.take_along_axis(bends[:, :, None, :, 0], turns, axis=-1).min(axis=-1)
    cuts = np.broadcast_to(bends[:, :, [0, 6], 1].min(axis=-1)[..., None], bases.shape)
    return own, np.stack([bases, cuts], axis=-1)


def _wrong_triangles(mesh: TriangleMesh, masks: Masks) -> int:
    """Coarse triangles, of the first few, whose triangles are not those of the readable form; 2 for each."""
    wrong = vertex = triangle = 0
    for mask in masks.ravel()[:CHECKED].tolist():
        is_half = mask >> 60 >= FIRST_HALF
        own = half_strips(mask) if is_half else strips(mask & NODE_BITS)
        expected = np.array(own, np.uint32).reshape(-1, 3) + vertex
        got = mesh.triangles[triangle : triangle + len(expected)]
        wrong += 2 * (not np.array_equal(expected, got))
        vertex, triangle = vertex + (mask & NODE_BITS).bit_count(), triangle + len(expected)
    return wrong
