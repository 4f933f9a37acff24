"""Which grid leaves at most so many triangles, and hardly fewer? Found by counting passes alone."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.grid import MAX_CELLS, Grid
from lodbench.kernels.cluster.quadric_clustering.host import QuadricClustering
from lodbench.kernels.cluster.quadric_clustering.params import Params
from lodbench.kernels.cluster.quadric_clustering.upload import Upload
from lodbench.kernels.device import Device
from lodbench.kernels.stages.scan import chunk_count, chunk_local
from lodbench.kernels.stages.timeline import Timeline

CLOSE = 0.95  # at least this share of the target counts as met
_SAMPLE = 1 << 16  # triangles of a first, rough count
_MOST_COUNTS = 60


@dataclass(frozen=True)
class Found:
    """The grid that a search settled on.

    Attributes:
        cells: real number of cubic cells along the longest axis.
        triangles: how many survive; never more than `target`.
        target: what was asked for.
        met: `triangles` is at least 95 % of `target`.
        counts: full counting passes made.
    """

    cells: float
    triangles: int
    target: int
    counts: int

    @property
    def met(self) -> bool:
        return self.triangles >= CLOSE * self.target

    @property
    def gap(self) -> int:
        """Triangles short of the target."""
        return self.target - self.triangles


def prepare_target(
    device: Device, mesh: TriangleMesh, target_count: int, params: Params
) -> tuple[QuadricClustering, Found]:
    """The mesh uploaded once, the grid found, and a frame ready to run.

    Args:
        device: where to run.
        mesh: what to simplify.
        target_count: triangles wanted at most.
        params: everything but `cells`, which the search replaces.

    Returns:
        The prepared system, whose setup has the stage "search", and what the search found.
    """
    upload = Upload(device, mesh)
    found = find_cells(upload, target_count)
    return QuadricClustering(upload, dataclasses.replace(params, cells=found.cells)), found


def find_cells(upload: Upload, target_count: int) -> Found:
    """The grid of cubic cells with at most `target_count` surviving triangles and at least 95 % of them.

    The cell edge is a real number, so almost any count can be hit; where the mesh allows none (a flat lattice, a
    handful of triangles), the nearest grid below the target. Duplicates count, as they stay unless asked otherwise.

    Raises:
        ValueError: a negative target.
    """
    if target_count < 0:
        raise ValueError(f"target_count: expected at least 0, got {target_count}")
    with upload.setup.host("search"):
        return _Search(upload, int(target_count)).run()


class _Search:
    """Counts of survivors on the device, and where they led so far."""

    def __init__(self, upload: Upload, target: int) -> None:
        device = self._device = upload.device
        self._upload = upload
        self._target = target
        self._full = 0
        mesh = upload.mesh
        program = upload.program
        local = chunk_local(device)
        ids = device.allocate("cell_ids", mesh.vertex_count, np.uint32)
        chunks = chunk_count(device, mesh.vertex_count)
        grid = Grid.over(upload.low, upload.high, 1)
        self._cells = program.launch(
            "quadric_clustering_setup_cells", chunks, stage="search", local=local,
            positions=upload.positions, cell_ids=ids, vertex_count=mesh.vertex_count,
            chunk_count=chunks, **grid.arguments,
        )  # fmt: skip
        chunks = chunk_count(device, mesh.triangle_count)
        self._survivors = device.allocate("survivors", chunks, np.uint32)
        self._count = program.launch(
            "quadric_clustering_setup_survivors", chunks, stage="search", local=local,
            cell_ids=ids, triangles=upload.triangles, survivors=self._survivors, stride=1,
            sample_count=mesh.triangle_count, chunk_count=chunks,
        )  # fmt: skip

    def count(self, cells: float, stride: int = 1) -> int:
        """Survivors on the grid of `cells`; an estimate from every `stride`-th triangle."""
        triangles = self._upload.mesh.triangle_count
        grid = Grid.over(self._upload.low, self._upload.high, cells)
        samples = -(-triangles // stride)
        self._cells.set(**grid.arguments)
        self._count.set(stride=stride, sample_count=samples)
        self._cells(Timeline())
        self._count(Timeline())
        found = int(self._device.read(self._survivors).sum(dtype=np.int64))
        self._full += stride == 1
        return found if stride == 1 else round(found * triangles / samples)

    def most_cells(self) -> float:
        """The finest grid of cubic cells: 2**27 in all, for a box this long."""
        extents = self._upload.high - self._upload.low
        longest = float(extents.max())
        if longest <= 0:
            return 1.0
        low, high = 1.0, float(MAX_CELLS)
        for _ in range(60):
            middle = math.sqrt(low * high)
            cells = math.prod(max(1, math.ceil(e / longest * middle - 1e-9)) for e in extents)
            low, high = (middle, high) if cells <= MAX_CELLS else (low, middle)
        return low

    def guess(self) -> float:
        """Cells for a surface like its box's: two triangles for each of 1.2 cells per cell edge squared."""
        extents = self._upload.high - self._upload.low
        x, y, z = extents / max(float(extents.max()), 1e-300)
        area = max(1.4 * (x * y + y * z + z * x), 0.05)
        return math.sqrt(self._target / (2.4 * area))

    def run(self) -> Found:
        """A rough search on a sample, then full counts from where it led."""
        triangles = self._upload.mesh.triangle_count
        if not triangles or not self._target:
            return Found(1.0, 0, self._target, 0)
        most = self.most_cells()
        cells = min(max(self.guess(), 1.0), most)
        stride = max(1, triangles // _SAMPLE)
        if stride > 1:
            cells, _ = self._bracket(cells, most, stride, 0.96, 0.99, 8)
        cells, count = self._bracket(cells, most, 1, CLOSE, 1.0, _MOST_COUNTS)
        return Found(cells, count, self._target, self._full)

    def _bracket(
        self, cells: float, most: float, stride: int, least: float, limit: float, tries: int
    ) -> tuple[float, int]:
        """Cells and survivors, between `least` and `limit` of the target where found; else the most below `limit`.

        Survivors grow about as the square of the cells along an axis; next to a bracket that is too coarse and one
        that is too fine, the next guess lies between them by that law, every third one in the middle.
        """
        target = self._target
        aim = 0.5 * (least + limit) * target
        best = below = (1.0, 0)  # one cell: nothing survives
        above: tuple[float, int] | None = None
        stuck = 0
        for turn in range(tries):
            count = self.count(cells, stride)
            if count <= limit * target:
                stuck = 0 if count > best[1] else stuck + 1
                best = max(best, (cells, count), key=lambda found: found[1])
                below = (cells, count)
            else:
                above = (cells, count)
            if least * target <= count <= limit * target:
                break
            ratio = math.sqrt(aim / max(count, 1))
            if above is None:
                # all there is to survive does, or nothing more comes: a finer grid is of no use
                if cells >= most or count >= self._upload.mesh.triangle_count or stuck > 4:
                    break
                cells = min(cells * min(max(ratio, 1.1), 2.0), most)
                continue
            span = math.log(above[0] / below[0])
            if span < 1e-7:
                break
            share = 0.5
            if turn % 3 < 2 and below[1] > 0:
                share = math.log(aim / below[1]) / math.log(above[1] / below[1])
            elif turn % 3 < 2:
                share = 1 - math.log(math.sqrt(above[1] / aim)) / span
            cells = below[0] * math.exp(span * min(max(share, 0.02), 0.98))
        return best
