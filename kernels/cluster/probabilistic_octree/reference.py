"""The published octree in float64, written for reading: what is written to which slot, and what is read back.

Cells are decided in float32; keys and slots are whole numbers and the device's to the bit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.cluster.octree.reference import RIDGES, Floats, Integers, morton
from lodbench.kernels.cluster.probabilistic_octree.params import Params
from lodbench.kernels.cluster.quadric_clustering.reference import place

NO_SLOT = -1


def hashed(x: NDArray[np.integer]) -> NDArray[np.uint32]:
    """The end of MurmurHash3."""
    x = x.astype(np.uint32)
    x = (x ^ (x >> np.uint32(16))) * np.uint32(0x85EBCA6B)
    x = (x ^ (x >> np.uint32(13))) * np.uint32(0xC2B2AE35)
    return x ^ (x >> np.uint32(16))


def keys_of(codes: Integers, up: int, finest: int) -> Integers:
    """The keys of the cells so many levels above the finest ones of these codes."""
    return 1 + (((finest - up) << 27) | (codes >> (3 * up)))


def slots_of(keys: Integers, params: Params) -> Integers:
    """Where keys are hashed to; the root's slot is its own."""
    found = hashed(keys ^ params.seed).astype(np.int64) % (params.slots - 1) + 1
    return np.where(keys == 1, 0, found)


def written(corners: Integers, up: int, params: Params) -> NDArray[np.bool_]:
    """Which corners, numbered through all triangles, write so many levels above the finest."""
    if params.construction == "full":
        return np.ones(len(corners), bool)
    drawn = hashed(hashed(corners + params.seed).astype(np.int64) + up)
    return (drawn & np.uint32((1 << up) - 1)) == 0


@dataclass(frozen=True)
class Table:
    """What a slot holds after all was written; a row per slot where the shape says m.

    Attributes:
        grid: of the finest cells; `codes` are those of the vertices, (n,).
        low, high: smallest and largest key written, (m,); 0 where none was.
        keys: the different keys that were written.
        edges: of the node's cell where it has its slot alone, else 1, in units of the finest cell edge, (m,).
        A, c, points: of such slots, sums in own edges and representatives in finest edges, (m, 3, 3), (m,), (m, 3).
        errors: in finest edges, infinite where nothing is to be read, (m,).
        margins: how far each was from being placed otherwise, as a share of the limit that decided, (m,).
    """

    grid: Grid
    codes: Integers
    low: Integers
    high: Integers
    keys: Integers
    edges: Floats
    A: Floats
    points: Floats
    errors: Floats
    margins: Floats

    @property
    def collided(self) -> int:
        """Keys that share their slot with another."""
        return len(self.keys) - int(((self.low == self.high) & (self.high > 0)).sum())


def write(mesh: TriangleMesh, params: Params) -> Table:
    """The table after construction, representatives and errors solved.

    Source: DeCoro & Tatarchuk 2007, slides 12, 15 and 29-33.
    """
    finest, m = params.grid_cells.bit_length() - 1, params.slots
    grid = Grid.over(*mesh.box, params.grid_cells)
    points32 = grid.points(mesh.positions)
    most = np.array(grid.counts, np.int64) - 1
    codes = morton(np.clip((points32 * grid.per_axis).astype(np.int64), 0, most))
    points = points32.astype(np.float64)

    p = points[mesh.triangles].reshape(-1, 3, 3)
    normal = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    length = np.linalg.norm(normal, axis=1)
    normal = np.repeat(normal / np.where(length > 0, length, 1)[:, None], 3, axis=0)
    area = np.repeat(length / 6, 3)
    at, code = p.reshape(-1, 3), codes[mesh.triangles].reshape(-1)
    low, high = np.full(m, np.iinfo(np.int64).max), np.zeros(m, np.int64)
    A, b, c, corners = np.zeros((m, 3, 3)), np.zeros((m, 3)), np.zeros(m), np.zeros((m, 4))
    keys: list[Integers] = []
    for up in range(finest + 1):
        rows = np.flatnonzero(written(np.arange(len(at)), up, params))
        share = 2.0**up if params.construction == "randomised" else 1.0
        key = keys_of(code[rows], up, finest)
        slot = slots_of(key, params)
        keys.append(np.unique(key))
        np.minimum.at(low, slot, key)
        np.maximum.at(high, slot, key)
        local = at[rows] / 2.0**up - cells_at(key) - 0.5
        n, weight = normal[rows], share * area[rows]
        d = -np.einsum("ni,ni->n", n, local)
        np.add.at(A, slot, weight[:, None, None] * n[:, :, None] * n[:, None, :])
        np.add.at(b, slot, (weight * d)[:, None] * n)
        np.add.at(c, slot, weight * d * d)
        np.add.at(corners, slot, share * np.concatenate([local, np.ones((len(rows), 1))], 1))
    low[high == 0] = 0

    alone = (low == high) & (high > 0)
    alone[0] = True
    high[0] = max(high[0], 1)
    level = (high - 1) >> 27
    edges = np.where(alone, 2.0 ** (finest - level), 1.0)
    mean = corners[:, :3] / np.maximum(corners[:, 3:], 1)
    rows = np.flatnonzero(alone)
    b_mean = np.einsum("nij,nj->ni", A[rows], mean[rows]) + b[rows]
    step, margins = np.zeros((m, 3)), np.full(m, np.inf)
    step[rows], _, margins[rows] = place(A[rows], b_mean, "robust", 1.0, ridges=RIDGES)
    x = mean + step
    energy = np.einsum("ni,nij,nj->n", x, A, x) + 2 * np.einsum("ni,ni->n", b, x) + c
    if params.rule == "rms":
        energy /= np.maximum(np.trace(A, axis1=1, axis2=2), 1e-30)
    errors = np.where(alone & (corners[:, 3] > 0), np.sqrt(np.maximum(energy, 0)) * edges, np.inf)
    centre = cells_at(np.where(alone, high, 1)) + 0.5
    return Table(
        grid, codes, low, high, np.concatenate(keys), edges, A,
        (centre + x) * edges[:, None], errors, margins,
    )  # fmt: skip


def cells_at(keys: Integers) -> Floats:
    """x, y and z of the cells of these keys in their level's grid, (n, 3)."""
    own = (keys - 1) & 0x7FFFFFF
    return np.stack(
        [sum(((own >> (3 * bit + axis)) & 1) << bit for bit in range(9)) for axis in range(3)], 1
    ).astype(np.float64)


def read(table: Table, codes: Integers, level: int, params: Params) -> Integers:
    """The slots of the cells of a level, (n,); NO_SLOT where another key was written there, or none."""
    finest = params.grid_cells.bit_length() - 1
    key = keys_of(codes, finest - level, finest)
    slot = slots_of(key, params)
    there = (table.low[slot] == key) & (table.high[slot] == key)
    return np.where(there | (level == 0), slot, NO_SLOT)


def cut(table: Table, errors: NDArray[np.floating], limit: float, params: Params) -> Integers:
    """The slot of each vertex, (n,): from the root on the first whose error keeps to the limit, else the last."""
    chosen = np.zeros(len(table.codes), np.int64)
    met = np.zeros(len(table.codes), bool)
    for level in range(params.grid_cells.bit_length()):
        slot = read(table, table.codes, level, params)
        better = ~met & (slot != NO_SLOT)
        chosen = np.where(better, slot, chosen)
        met |= better & (errors[slot] <= limit)
    return chosen


def cut_binary(
    table: Table, errors: NDArray[np.floating], limit: float, params: Params
) -> Integers:
    """The same by halving the levels, each vertex by itself."""
    chosen = np.zeros(len(table.codes), np.int64)
    slots = np.stack(
        [read(table, table.codes, level, params) for level in range(params.grid_cells.bit_length())]
    )
    for v in range(len(table.codes)):
        low, high, found, last, last_level = 0, len(slots), None, 0, 0
        while low < high:
            middle = level = (low + high) // 2
            while slots[level, v] == NO_SLOT and level > low:
                level -= 1
            slot = slots[level, v]
            if slot != NO_SLOT and errors[slot] <= limit:
                found, high = slot, level
            else:
                if slot != NO_SLOT and level >= last_level:
                    last, last_level = slot, level
                low = middle + 1
        chosen[v] = last if found is None else found
    return chosen
