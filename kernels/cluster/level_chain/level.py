"""What is kept of a level of a chain, on the device and for the host."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.opencl import Buffer

Read = Callable[..., NDArray]  # Device.read


@dataclass(frozen=True, eq=False)
class Level:
    """One level.

    ```
    words      ulong [2 * words]         of 64 cells each: their bits, occupied cells before them
    sums       float [maps, capacity, 16] or long [capacity, 14]     the cluster map, in units of the level's cells
                                         or as it was added up
    new_ranks  uint  [capacity]          output vertex of a cell
    vertices   float [3 * capacity]      output positions
    triangles  uint  [3 * triangles]     output triangles
    counts     uint  [2]                 live output vertices and triangles
    parents    uint  [capacity before]   the cell, by rank, of each output vertex of that level; None for the first
    ```

    Attributes:
        grid: the level's.
        occupied: cells with a vertex.
    """

    grid: Grid
    occupied: int
    words: Buffer
    sums: Buffer
    new_ranks: Buffer
    vertices: Buffer
    triangles: Buffer
    counts: Buffer
    parents: Buffer | None = None

    @property
    def capacity(self) -> int:
        """Rows of what is kept per cell, at least 1."""
        return max(self.occupied, 1)

    def size(self, read: Read) -> tuple[int, int]:
        """Vertices and triangles of the last frame."""
        vertices, triangles = map(int, read(self.counts))
        return vertices, triangles

    def mesh(self, read: Read) -> TriangleMesh:
        """The last frame's."""
        vertices, triangles = self.size(read)
        return TriangleMesh(read(self.vertices, vertices), read(self.triangles, triangles))

    def map_from(self, finer: Level, read: Read) -> NDArray[np.uint32]:
        """The vertex of this level for each one of the level before, (n,); 0xFFFFFFFF where its cell has none."""
        assert self.parents is not None
        vertices, _ = finer.size(read)
        return read(self.new_ranks)[read(self.parents, vertices)]
