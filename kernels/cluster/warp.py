"""Warps of the clustering grid: where vertices lie in the space that the grid is laid over.

Only the cell of a vertex is decided there; quadrics, means and representatives stay in the model's own space. The even
grid over the warped positions is the same as an uneven one over the model, whose planes went through the inverse.

Source: DeCoro & Tatarchuk, Real-time Mesh Simplification Using the GPU, I3D 2007, for both ideas; what the paper leaves
open, such as how a density is normalised and what becomes of places that are not seen, is a reconstruction.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from lodbench.datasets_gen.arrays import box
from lodbench.kernels.cluster.grid import Cells, Grid

Doubles = NDArray[np.float64]
Singles = NDArray[np.float32]
Region = tuple[float, float, float, float, float]
"""x, y, z of the centre and the radius, in model units, and the weight."""

STEPS = 1024  # of a table along each axis
FAR = 1e6  # boxes: a region farther off, wider or narrower changes nothing that float32 shows
FILE = "cluster/warp.cl"
DEFINES = {"WARPED": 1, "WARP_STEPS": STEPS}
PARALLEL = 1e-6  # of the distance per box: less narrowing than this is none
LARGEST = 1e30  # of a matrix in float32, whose products are finite then
MOST_EVEN = 500  # cells along an axis: a cube of them is within MAX_CELLS
GUARD = 0.05  # of what is seen, to each side: above a cell where a grid has 20 of them
NEAREST = 1e-6  # of the depth in the middle of what is seen: nearer places, and those behind the eye, count as there


def density(t: Doubles, regions: Sequence[tuple[float, float, float]]) -> Doubles:
    """Cells per length along one axis, 1 far from all regions: 1 + sum (weight - 1) exp(-(t - centre)^2 / 2 radius^2).

    Args:
        t: places along the axis, any unit.
        regions: centre, radius (that of a standard deviation) and weight, at least 1, in the same unit.
    """
    rises = [(w - 1) * np.exp(-(((t - c) / r) ** 2) / 2) for c, r, w in regions]
    return 1 + sum(rises, np.zeros_like(t))


def region_warp(t: Doubles, regions: Sequence[tuple[float, float, float]]) -> Doubles:
    """The integral of `density` from 0 to `t` over that from 0 to 1: rises from 0 to 1, no change without regions.

    Source: DeCoro & Tatarchuk 2007, biased Gaussian; that it is integrated to an erf follows, the scale is ours.
    """

    def integral(x: Doubles) -> Doubles:
        total = np.array(x)
        for centre, radius, weight in regions:
            c, r = np.clip(centre, -FAR, FAR), np.clip(radius, 1 / FAR, FAR) * np.sqrt(2)
            total += (weight - 1) * r * np.sqrt(np.pi) / 2 * (erf((x - c) / r) + erf(c / r))
        return total

    return integral(t) / integral(np.ones(1))


class Warp(ABC):
    """Where vertices of one mesh lie in the grid's space; `kernel` does the same as `__call__`, bit for bit on a CPU.

    Attributes:
        kernel: that warps.
        tables: what it reads besides positions, by name.
    """

    kernel: str
    tables: dict[str, Singles]

    def __init__(self, box: tuple[Doubles, Doubles]) -> None:
        """`box`: lower and upper corner of all positions, (3,) model units."""
        grid = Grid.over(*box, 1)
        self.box, self.scale, self.low = box, grid.prescale, grid.low
        self.tables = {}

    def even(self, cells: Cells) -> Grid:
        """The grid without the warp, whose units lengths are in; of so many cells, unless it had too many in all."""
        return Grid.over(*self.box, cells if isinstance(cells, tuple) else min(cells, MOST_EVEN))

    @property
    @abstractmethod
    def arguments(self) -> dict[str, Any]:
        """Values that the kernel is given."""

    @abstractmethod
    def __call__(self, positions: Singles) -> tuple[Singles, Singles]:
        """Positions (n, 3) float32 to places in the grid's space (n, 3) and stretches (n, 3).

        A stretch is length in the model over length there, along x, y and z; lengths in that space are those of the
        model, times a power of two, where nothing is stretched.
        """

    def cells(self, positions: Singles, cells: Cells) -> tuple[NDArray[np.int64], Doubles]:
        """The linear cell number of each of `positions` (n, 3), and how far it lets one step, (n, 3)."""
        places, stretch = self(positions)
        even = self.even(cells)
        grid = Grid.over(*(box(places) if len(places) else self.box), cells)
        values = {name: np.float32(value) for name, value in self.limits(grid, even).items()}
        limits = np.minimum(stretch * values["edge"], values["longest"])
        return grid.cells_of(grid.points(places)), limits.astype(np.float64)

    def limits(self, grid: Grid, even: Grid) -> dict[str, float]:
        """The largest edge of a cell that is not stretched, and of any, in units of the `even` grid."""
        return {"edge": grid.edge / float(even.unit), "longest": max(even.extent, 1.0)}


class TableWarp(Warp):
    """Each axis by itself, F(t) for t from 0 to 1 along the box, by straight lines between entries of a table."""

    kernel = "cluster_warp_table"

    def __init__(self, box: tuple[Doubles, Doubles], rising: Doubles) -> None:
        """`rising`: F at even steps, (3, STEPS + 1), each row from 0 to 1 and nowhere falling."""
        super().__init__(box)
        extent = (np.asarray(box[1], np.float64) - box[0]) * self.scale
        flat = extent <= 0
        table = rising - np.linspace(0, 1, STEPS + 1)
        table[flat] = table[:, [0, -1]] = 0
        self.table = table.astype(np.float32)
        self.tables = {"table": self.table}
        self.extent = extent.astype(np.float32)
        with np.errstate(over="ignore"):
            steps = np.where(flat, 0, STEPS / np.where(flat, 1, extent)).astype(np.float32)
        self.steps = np.minimum(steps, np.float32(3e38))

    @property
    def arguments(self) -> dict[str, Any]:
        """See `Warp`."""
        return {
            "low": (*self.low, self.scale),
            "extent": (*self.extent, 0),
            "steps_per_unit": (*self.steps, 0),
        }

    def __call__(self, positions: Singles) -> tuple[Singles, Singles]:
        """See `Warp`."""
        p = positions * np.float32(self.scale)
        s = (p - self.low) * self.steps
        i = np.clip(s.astype(np.int32), 0, STEPS - 1)
        axis = np.arange(3)
        start = self.table[axis, i]
        rise = self.table[axis, i + 1] - start
        slope = rise * np.float32(STEPS) + np.float32(1)
        stretch = (np.float32(1) / np.maximum(slope, np.float32(1e-6))).astype(np.float32)
        shift = (start + (s - i.astype(np.float32)) * rise) * self.extent
        return (p + shift).astype(np.float32), stretch


class ViewWarp(Warp):
    """Places after projection, scaled per axis to the model's lengths in the middle of what is seen.

    x and y are normalised device coordinates. So is the depth as published, "ndc": its cells grow with the square of
    the distance, and most are spent on what is nearest. "log", a reconstruction: the logarithm of the distance, so
    that a cell is about as deep as it is wide everywhere; a parallel projection has no such and takes the other.

    The middle is the median of what is seen along each axis; cells are cubes there. The grid's box is that of the
    vertices that are seen and a band about it: those beyond count as on its border, those behind the eye as on the
    nearest one, so that what is out of sight falls into few cells, and into none that holds what is seen.
    """

    kernel = "cluster_warp_view"

    def __init__(
        self,
        box: tuple[Doubles, Doubles],
        positions: Singles,
        world_to_clip: Doubles,
        depth: str = "log",
    ) -> None:
        """The view as it is from these positions.

        Args:
            box: of `positions`.
            positions: of all vertices, (n, 3).
            world_to_clip: (4, 4), of the same space as the positions.
            depth: "log" or "ndc".

        Raises:
            ValueError: the matrix cannot be inverted, or not at the mesh's scale.
        """
        super().__init__(box)
        rows = np.array(world_to_clip, np.float64)
        rows[:, 3] += rows[:, :3] @ (self.low.astype(np.float64) / self.scale)
        rows[:, :3] /= self.scale
        rows /= np.abs(rows[3]).max() or 1.0
        u = positions.astype(np.float64) * self.scale - self.low
        seen = self._seen(u @ rows[:, :3].T + rows[:, 3])
        middle = np.median(seen, axis=0)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            try:
                at = np.linalg.solve(rows, [*middle[:3], 1.0])
            except np.linalg.LinAlgError:
                at = np.full(4, np.nan)
            away = rows[3] @ (at / at[3])
            rows = rows / away
            rows[:3] -= middle[:3, None] * rows[3]
            reach = 1 / np.linalg.norm(rows[:3, :3], axis=1)
            rows[:3] *= reach[:, None]
        if not (np.abs(rows) < LARGEST).all():  # a NaN is not either
            raise ValueError(
                "view: expected a world_to_clip that can be inverted about the mesh, got one that cannot"
            )
        least, most = ((end(seen[:, :3], 0) - middle[:3]) * reach for end in (np.min, np.max))
        narrowing = float(np.linalg.norm(rows[3, :3]))
        self.log_scale = np.float32(0)
        if depth == "log" and narrowing > PARALLEL:
            self.log_scale = np.float32(np.log(2) / narrowing)
            ends = np.array([seen[:, 3].min(), seen[:, 3].max()]) / away
            least[2], most[2] = np.log2(np.maximum(ends, NEAREST)) * self.log_scale
        band = GUARD * (most - least)
        least, most = least - band, most + band
        self.rows = rows.astype(np.float32)
        self.least, self.most = least.astype(np.float32), most.astype(np.float32)

    @staticmethod
    def _seen(clip: Doubles) -> Doubles:
        """x, y, z after projection and w of what is seen, (n, 4); where nothing is, the corners of what could be."""
        w = clip[:, 3]
        seen = (w > 0) & (np.abs(clip[:, :3]) <= w[:, None]).all(1)
        if not seen.any():
            return np.concatenate([-np.ones((1, 4)), np.zeros((1, 4)), np.ones((1, 4))])
        return np.column_stack([clip[seen, :3] / w[seen, None], w[seen]])

    @property
    def arguments(self) -> dict[str, Any]:
        """See `Warp`."""
        rows = {f"row_{name}": tuple(row) for name, row in zip("xyzw", self.rows, strict=True)}
        return {
            "low": (*self.low, self.scale),
            "least": (*self.least, NEAREST),
            "most": (*self.most, self.log_scale),
            **rows,
        }

    def __call__(self, positions: Singles) -> tuple[Singles, Singles]:
        """See `Warp`."""
        x, y, z = (positions * np.float32(self.scale) - self.low).T
        clip = [(x * r[0] + y * r[1]) + (z * r[2] + r[3]) for r in self.rows]
        w = np.maximum(clip[3], np.float32(NEAREST))
        places = np.stack(clip[:3], axis=1) / w[:, None]
        if self.log_scale > 0:
            places[:, 2] = log2(w) * self.log_scale
        wide = w if self.log_scale > 0 else np.maximum(w, w * w)
        stretch = np.repeat(wide[:, None], 3, axis=1)
        return np.clip(places, self.least, self.most).astype(np.float32), stretch


def log2(w: Singles) -> Singles:
    """Nearly the logarithm to base 2 of `w` above 0: rises without a step, within 0.003, the same on any device."""
    bits = w.view(np.int32)
    t = ((bits & 0x007FFFFF) | 0x3F800000).view(np.float32) - np.float32(1)
    bent = t * np.float32(0.15) + np.float32(-0.57)
    whole = ((bits >> 23) - 127).astype(np.float32)
    return (whole + t * (t * bent + np.float32(1.42))).astype(np.float32)
