"""Figures of NURBS surfaces: against SciPy and the recursion, on conics, within a tolerance."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from lodbench.datasets_gen.nurbs_surface import NurbsSurface
from lodbench.harness.measure.figure import Figure, Seen
from lodbench.kernels.exactness import POSITION_LIMIT
from lodbench.kernels.nurbs.reference import cox_de_boor
from lodbench.kernels.nurbs.reference import stair as stair_values
from lodbench.kernels.nurbs.samples import Samples, first_knots, numbers
from lodbench.kernels.nurbs.tessellated import Tessellated
from lodbench.kernels.nurbs.tolerance import diagonal, distances
from lodbench.kernels.opencl import Unsupported

Doubles = NDArray[np.float64]

FLOAT64, FLOAT32 = 1e-12, 1e-6  # of basis functions
ROUNDINGS32 = 8 * float(np.finfo(np.float32).eps)
"""What is exact to float32: a quotient of two sums of a few products, relative to the largest."""
FINER = 7  # parts of a segment, at whose ends distances are measured; those that chose segments saw other places


def _tessellated(seen: Seen) -> Tessellated:
    if not isinstance(seen.prepared, Tessellated):
        raise Unsupported("needs surfaces on grids, subject has none")
    return seen.prepared


def _grid_points(prepared: Tessellated) -> list[Doubles]:
    """Points of each surface as the device made them, (rows, columns, 3)."""
    (mesh,) = prepared.result()
    return [
        mesh.positions[g.first : g.first + g.vertices]
        .reshape(g.rows, g.columns, 3)
        .astype(np.float64)
        for g in prepared.grids
    ]


def off_scipy(seen: Seen) -> Figure:
    """The largest error of a coordinate against SciPy's splines."""
    prepared, worst = _tessellated(seen), 0.0
    grids = zip(prepared.model.surfaces, prepared.grids, _grid_points(prepared), strict=True)
    for surface, grid, points in grids:
        u, v = numbers(surface.knots_u, grid.u), numbers(surface.knots_v, grid.v)
        worst = np.max([worst, np.abs(points - scipy_points(surface, u, v)).max()])  # NaN is worst
    return Figure(
        float(worst) / prepared.model.diagonal, POSITION_LIMIT, f"{prepared.vertices:,} points"
    )


def scipy_points(surface: NurbsSurface, u: Doubles, v: Doubles) -> Doubles:
    """SciPy's points on a grid of parameters, (n_u, n_v, 3)."""
    weights = surface.weights[..., None]
    net = np.concatenate([surface.points * weights, weights], axis=2)
    rows = BSpline(surface.knots_u, net, surface.degree_u)(u)
    found = BSpline(surface.knots_v, rows.transpose(1, 0, 2), surface.degree_v)(v)
    found = found.transpose(1, 0, 2)
    return found[..., :3] / found[..., 3:]


# basis functions


def _first_side(seen: Seen) -> tuple[Doubles, int, Samples]:
    """Knots, degree and samples along u of the first surface."""
    prepared = _tessellated(seen)
    surface = prepared.model.surfaces[0]
    return surface.knots_u, surface.degree_u, prepared.grids[0].u


def _recursion(
    knots: Doubles, degree: int, samples: Samples
) -> Iterator[tuple[int, float, Doubles]]:
    """Of each sample its span's first knot, its parameter, and all functions that are not zero there."""
    for begin, x in zip(first_knots(knots)[samples.spans], numbers(knots, samples), strict=True):
        rows = range(begin - degree, begin + 1)
        yield int(begin), x, np.array([cox_de_boor(knots, i, degree, x) for i in rows])


def _on_device(seen: Seen) -> Doubles:
    """Basis functions as the device made them, (samples, degree + 1)."""
    _, degree, samples = _first_side(seen)
    planes = seen.device.read(_tessellated(seen).buffers["weights"])
    return planes[: degree + 1, : len(samples)].T.astype(np.float64)


def _samples_seen(seen: Seen) -> str:
    knots, degree, samples = _first_side(seen)
    times = np.unique(knots, return_counts=True)[1][1:-1].max(initial=1)
    return f"{len(samples):,} samples, degree {degree}, a knot {times} times"


def stair(seen: Seen) -> Figure:
    """The stair strategy in float64 against the recursion."""
    knots, degree, samples = _first_side(seen)
    off = [
        np.abs(stair_values(knots, begin, degree, x) - expected).max()
        for begin, x, expected in _recursion(knots, degree, samples)
    ]
    return Figure(float(np.max(off)), FLOAT64, _samples_seen(seen))


def basis(seen: Seen) -> Figure:
    """The device's float32 against the recursion in float64."""
    expected = np.stack([values for _, _, values in _recursion(*_first_side(seen))])
    return Figure(float(np.abs(_on_device(seen) - expected).max()), FLOAT32, _samples_seen(seen))


def unity(seen: Seen) -> Figure:
    """The sum of the device's basis functions against 1."""
    off = np.abs(_on_device(seen).sum(axis=1) - 1).max()
    return Figure(float(off), ROUNDINGS32, _samples_seen(seen))


def end(seen: Seen) -> Figure:
    """At the end parameter the last function is 1 and the others 0."""
    last = _on_device(seen)[-1]
    return Figure(float(np.abs(last - np.eye(len(last))[-1]).max()), 0, _samples_seen(seen))


# points

CONICS: dict[str, Callable[[Doubles], Doubles]] = {
    "cylinder": lambda p: np.linalg.norm(p[:, :2], axis=1) - 1,
    "sphere": lambda p: np.linalg.norm(p, axis=1) - 1,
    "torus": lambda p: np.hypot(np.linalg.norm(p[:, :2], axis=1) - 1, p[:, 2]) - 0.4,
}
"""How far points lie off the conics of `datasets_gen/nurbs.py`, whose largest radius is 1."""


def off_conic(name: str) -> Callable[[Seen], Figure]:
    """How far the device's points lie off this one of `CONICS`."""

    def measure(seen: Seen) -> Figure:
        (mesh,) = seen.prepared.result()
        off = np.abs(CONICS[name](mesh.positions.astype(np.float64))).max()
        return Figure(float(off), ROUNDINGS32, f"{mesh.vertex_count:,} points")

    return measure


def distance(seen: Seen) -> Figure:
    """The largest distance of the device's triangles to the surface, at parameters that did not choose them."""
    prepared, worst = _tessellated(seen), 0.0
    grids = zip(prepared.model.surfaces, prepared.grids, _grid_points(prepared), strict=True)
    for surface, grid, points in grids:
        counts = [np.bincount(side.spans[:-1]) for side in (grid.u, grid.v)]
        off, *_ = distances(surface, counts, FINER, points)
        worst = np.max([worst, off.max()])
    _, triangles = prepared.live()
    share = float(worst) / diagonal(prepared.model)
    return Figure(share, seen.params.tolerance, f"{triangles:,} triangles")
