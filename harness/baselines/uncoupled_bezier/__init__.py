"""The grid that each cell of a Bezier patch would take by itself, whatever its neighbours do: a bound, full of cracks.

A cell of the coarse mesh is cut into power-of-two segments, a number for each direction, and along one of its
diagonals, so that the mean error of all cells together, at equal parameters and across the surface, is least for as
many triangles: each adds segments as long as a triangle saves more than its `price`. No crack-free tessellation by such
grids can do with less: its edges must suit both sides. Counter `least_share` is a bound of all grids, whatever segments
they have: see there.

Source: none; Concheiro 2013, chapter 3, for the coarse cells.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import BezierPatches, TriangleMesh
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.kernels.bezier.reference import Doubles, normals_at, points_at
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.parameters import Parameters, Range
from lodbench.kernels.system import Check, Frame

__all__ = ["SYSTEM", "Params"]

SAMPLES = 8  # of a cell's side, between the vertices of its grids
Grid = tuple[int, int, bool]  # segments along u and v, and is it cut along the other diagonal?


@dataclass(frozen=True)
class Params(Parameters):
    """What a cell may take, and what a triangle must save.

    Attributes:
        level: of resolution at the finest: 2^level segments along each side of a patch.
        depth: levels below the cells.
        price: mean error that a triangle must save, a share of the diagonal.
    """

    level: Annotated[int, Range(0, 7)] = 5
    depth: Annotated[int, Range(0, 3)] = 3
    price: Annotated[float, Range(0, open="low")] = 1e-9

    @property
    def base(self) -> int:
        """The level of the cells."""
        return max(self.level - self.depth, 0)

    @property
    def grids(self) -> list[Grid]:
        """All that a cell may choose from."""
        sizes = [1 << k for k in range(min(self.depth, self.level) + 1)]
        return list(product(sizes, sizes, (False, True)))


def _flat(P: Doubles, u: Doubles, v: Doubles, segments: tuple[int, int], other: bool) -> Doubles:
    """What the flat triangles of a grid over whole patches have at parameters, (m, n, 3)."""
    i, j = (
        np.minimum((t * n).astype(np.int64), n - 1) for t, n in zip((u, v), segments, strict=True)
    )
    a, b = u * segments[0] - i, v * segments[1] - j
    if other:
        low = a + b <= 1
        shares = [
            np.where(low, 1 - a - b, 0), np.where(low, a, 1 - b),
            np.where(low, 0, a + b - 1), np.where(low, b, 1 - a),
        ]  # fmt: skip
    else:
        low = b <= a
        shares = [
            1 - np.maximum(a, b), np.where(low, a - b, 0), np.minimum(a, b), np.where(low, 0, b - a),
        ]  # fmt: skip
    corners = ((0, 0), (1, 0), (1, 1), (0, 1))
    return sum(
        (
            share[:, None] * points_at(P, (i + di) / segments[0], (j + dj) / segments[1])
            for share, (di, dj) in zip(shares, corners, strict=True)
        ),
        np.zeros(3),
    )


def chosen_grids(P: Doubles, params: Params) -> NDArray[np.int64]:
    """The number of the grid of every cell, (m, cells along u, along v), in `params.grids`."""
    cells = 1 << params.base
    t = (np.arange(cells * SAMPLES) + 0.5) / (cells * SAMPLES)
    u, v = (a.ravel() for a in np.meshgrid(t, t, indexing="ij"))
    points, (normals, _) = points_at(P, u, v), normals_at(P, u, v)
    step = 1e-5
    areas = np.linalg.norm(
        np.cross(
            points_at(P, u + step, v) - points_at(P, u - step, v),
            points_at(P, u, v + step) - points_at(P, u, v - step),
        ),
        axis=-1,
    )
    areas /= areas.sum() or 1.0
    diagonal = np.linalg.norm(np.ptp(P.reshape(-1, 3), axis=0)) if len(P) else 1.0
    best = np.full((len(P), cells, cells), np.inf)
    chosen = np.zeros(best.shape, np.int64)
    for number, (along_u, along_v, other) in enumerate(params.grids):
        flat = _flat(P, u, v, (cells * along_u, cells * along_v), other)
        off = np.abs(((flat - points) * normals).sum(-1)) * areas / (diagonal or 1.0)
        error = off.reshape(len(P), cells, SAMPLES, cells, SAMPLES).sum((2, 4))
        cost = error + 2 * along_u * along_v * params.price
        chosen[cost < best] = number
        best = np.minimum(best, cost)
    return chosen


PLACES, INNER, STEP = 12, 7, 1e-3  # along a patch's side and within a triangle; of differences
ASPECTS = 2.0 ** np.arange(-6, 6.25, 0.25)  # of a cell of a grid: its share of u over that of v


def least_share(P: Doubles) -> float:
    """Triangles at equal mean error over those of one number of segments for all, of the best grids that could be.

    Each place of the surface has cells of whatever size, aspect and diagonal are best there, whatever its neighbours
    have, and vertices on the surface; in the limit of many triangles, over each of which the surface is quadratic, the
    mean error is inverse to their number. It is least where they are as dense as the root of the error at one size.
    """
    t = (np.arange(PLACES) + 0.5) / PLACES
    u, v = (a.ravel() for a in np.meshgrid(t, t, indexing="ij"))

    def at(i: int, j: int) -> Doubles:
        return points_at(P, u + i * STEP, v + j * STEP)

    normal = np.cross(at(1, 0) - at(-1, 0), at(0, 1) - at(0, -1))
    a = at(1, 0) + at(-1, 0) - 2 * at(0, 0)
    b = (at(1, 1) + at(-1, -1) - at(1, -1) - at(-1, 1)) / 4
    c = at(0, 1) + at(0, -1) - 2 * at(0, 0)
    a, b, c = ((second * normal).sum(-1).ravel() for second in (a, b, c))  # times area
    one = _mean_off(a, b, c)
    best = np.full(one.shape, np.inf)
    for aspect in ASPECTS:
        for twist in (b, -b):
            best = np.minimum(best, _mean_off(a * aspect, twist, c / aspect))
    return float(np.sqrt(best).mean() ** 2 / one.mean()) if one.any() else 1.0


def _mean_off(a: Doubles, b: Doubles, c: Doubles) -> Doubles:
    """The mean distance of (a x^2 + 2 b x y + c y^2) / 2 from its triangle over (0, 0), (1, 0), (1, 1)."""
    x, y = np.meshgrid((np.arange(INNER) + 2 / 3) / INNER, (np.arange(INNER) + 1 / 3) / INNER)
    total = np.zeros(a.shape)
    for p, q in zip(x[x > y], y[x > y], strict=True):
        total += np.abs(a * (p - p * p) + 2 * b * (q - p * q) + c * (q - q * q)) / 2
    return total / (x > y).sum()


def _pieces(
    P: Doubles, params: Params, chosen: NDArray[np.int64]
) -> Iterator[tuple[Doubles, NDArray]]:
    """Vertices and triangles of all cells that have the same grid."""
    cells = 1 << params.base
    for number, (along_u, along_v, other) in enumerate(params.grids):
        for row, column in product(range(cells), range(cells)):
            mine = chosen[:, row, column] == number
            if not mine.any():
                continue
            u = (row + np.arange(along_u + 1) / along_u) / cells
            v = (column + np.arange(along_v + 1) / along_v) / cells
            points = points_at(P[mine], np.repeat(u, len(v)), np.tile(v, len(u)))
            a = (np.arange(along_u)[:, None] * len(v) + np.arange(along_v)).ravel()
            b, c, d = a + len(v), a + len(v) + 1, a + 1
            rows = [a, b, d, b, c, d] if other else [a, b, c, a, c, d]
            faces = np.stack(rows, axis=1).reshape(-1, 3)
            first = np.arange(mine.sum())[:, None, None] * points.shape[1]
            yield points.reshape(-1, 3), (faces[None] + first).reshape(-1, 3)


def prepare(device: Device, patches: BezierPatches, params: Params) -> HostPrepared:
    """The call chooses grids and evaluates them."""
    P = patches.points.astype(np.float64)

    def call(frame: Frame) -> list[tuple[Doubles, NDArray]]:
        return list(_pieces(P, params, chosen_grids(P, params)))

    def read(output: list[tuple[Doubles, NDArray]]) -> list[TriangleMesh]:
        starts = np.cumsum([0, *(len(points) for points, _ in output)])
        vertices = np.concatenate([np.zeros((0, 3)), *(points for points, _ in output)])
        faces = [faces + start for (_, faces), start in zip(output, starts, strict=False)]
        triangles = np.concatenate([np.zeros((0, 3), np.int64), *faces])
        return [TriangleMesh(vertices.astype(np.float32), triangles.astype(np.uint32))]

    def verdict(meshes: Sequence[TriangleMesh]) -> Check:
        counts = np.array([2 * a * b for a, b, _ in params.grids])
        off = abs(meshes[0].triangle_count - int(counts[chosen_grids(P, params)].sum()))
        return Check(not off, "triangles more or fewer than expected", float(off), 0.0)

    def count(output: object) -> dict[str, float]:
        return {"least_share": least_share(P)}

    return HostPrepared(device, call, read, verdict, Timeline(), input_bytes=P.nbytes, count=count)


SYSTEM = host_system(
    "uncoupled_bezier",
    "a bound, in NumPy; coarse cells of Concheiro 2013, chapter 3",
    prepare,
    {"price_1e-7": Params(4, price=1e-7), "price_1e-8": Params(4, price=1e-8)},
    takes=(BezierPatches,),
    notes="each cell with the grid that it would take by itself; cracks wherever neighbours differ",
)
