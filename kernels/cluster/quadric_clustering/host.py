"""Quadric vertex clustering on a device: the cluster map, the walk that fills it, and the solve."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster import prepare as family
from lodbench.kernels.cluster.borders import NO_EDGES
from lodbench.kernels.cluster.clustering import Clustering
from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.cluster.quadric_clustering import slabs
from lodbench.kernels.cluster.quadric_clustering.params import HEAVINESS, Params
from lodbench.kernels.cluster.quadric_clustering.reference import KINDS, simplify
from lodbench.kernels.cluster.quadric_clustering.verdict import verdict
from lodbench.kernels.cluster.search import Found
from lodbench.kernels.cluster.unchanged import Unchanged
from lodbench.kernels.cluster.upload import Upload
from lodbench.kernels.opencl import Buffer, Device, Timeline, Unsupported
from lodbench.kernels.stages.scan import chunk_count, chunk_local
from lodbench.kernels.subject import POINT
from lodbench.kernels.system import Check

PLACEMENTS = {"robust": 0, "paper": 1, "average": 2}
SUM_LANES = 14
FOLDER = "cluster/quadric_clustering"
FILES = tuple(
    f"{FOLDER}/{name}.cl" for name in ("setup", "fragment", "geometry", "geometry_emit", "border")
)
FIXED_POINT = f"{FOLDER}/geometry_fixed_point.cl"
BORDER_FIXED_POINT = f"{FOLDER}/border_fixed_point.cl"
ATOMICS = "cl_khr_int64_base_atomics"
_PREFIX = "quadric_clustering_"


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> Clustering | Unchanged:
    """See `cluster/prepare.py`; fixed_point needs 64-bit atomics."""
    more = (slabs.FILE,) if slabs.chosen(device, params, mesh.triangle_count) == "slabs" else ()
    return family.prepare(device, mesh, params, QuadricClustering, (*FILES, *more))


def float_maps(device: Device, params: Params) -> bool:
    """One float map per chunk, else one of integers, which needs 64-bit atomics.

    Raises:
        Unsupported: the device has none.
    """
    integers = params.accumulate == "fixed_point" or (
        params.accumulate == "auto" and not device.is_cpu
    )
    if integers and ATOMICS not in device.facts.extensions:
        raise Unsupported(f"needs {ATOMICS}, device has none")
    return not integers


def placing(grid: Grid, params: Params) -> dict[str, Any]:
    """What the kernels of pass 2 are told of the placement."""
    per_box = 1 / grid.extent if grid.extent else 1.0
    return {"per_box": per_box, "placement": PLACEMENTS[params.placement]}


def fixed_point_scale(
    exponents: NDArray[np.floating],
    grid: Grid,
    triangle_count: int,
    border: NDArray[np.floating],
) -> tuple[float, float, float]:
    """Powers of two for A, b and positions, as large as sums of all triangles in one cell allow.

    Args:
        exponents: triangles by the exponent of a third of their area, (256,).
        grid: whose units areas are in.
        triangle_count: all there are.
        border: border edges that add planes, by the exponent of the square of their length, (256,).
    """
    most = np.exp2(np.arange(256) - 126.0)  # of an exponent
    area = 3 * float(exponents @ most) + 2 * HEAVINESS * float(border @ most)
    reach = 2 * max(grid.extent, 1.0)  # no corner is farther than sqrt(3) extents
    bounds = (area, area * reach, 3 * max(triangle_count, 1) * reach)
    exponent = [np.clip(62 - np.ceil(np.log2(max(b, 1e-30))), -100, 100) for b in bounds]
    scale_a, scale_b, scale_p = (float(2.0**e) for e in exponent)
    return scale_a, scale_b, scale_p


def squares_by_exponent(ends: NDArray[np.float32]) -> NDArray[np.float64]:
    """How many pairs of points, (k, 2, 3), have a distance whose square has each exponent of float32, (256,).

    Counts are the same in any order, which sums are not.
    """
    x, y, z = (ends[:, 1] - ends[:, 0]).T
    exponents = (x * x + y * y + z * z).view(np.uint32) >> np.uint32(23)
    return np.bincount(exponents, minlength=256).astype(np.float64)


class QuadricClustering(Clustering):
    """See `lodbench.kernels.cluster.quadric_clustering`.

    ```
    sums          float [chunks, capacity, 16] or long [capacity, 14]   the cluster map
    ```

    Attributes:
        accumulate: how it is filled: never "auto".
        floats: one float map per chunk, else one of integers.
        fused: passes 1 and 3 in one walk.
        slabs: what the walk leaves, where it goes by slabs.
        first, third: the stage names of passes 1 and 3.
    """

    params: Params
    slabs: slabs.Slabs | None = None

    def __init__(self, upload: Upload, params: Params, found: Found | None = None) -> None:
        super().__init__(upload, params, found)
        device = upload.device
        self.accumulate = slabs.chosen(device, params, self._triangles)
        self.floats = float_maps(device, params)
        self.fused = self.floats and params.strategy == "fused"
        if not self.floats:
            with self.setup.host("build"):
                self._programs.append(device.build(FIXED_POINT, BORDER_FIXED_POINT))
        self.first = "pass_1_and_3" if self.fused else "pass_1"
        self.third = "pass_1_and_3" if self.fused else "pass_3"
        with self.setup.host("size"):
            self.find_cells(self.first)
        self._prepare_sums()
        if params.holds_border and len(self.border):
            self._hold_border()
        self._prepare_solve()
        self.compact("pass_2")
        walked = None
        if self.fused:
            walked = {
                "kernel": _PREFIX + "geometry_emit_join", "pieces": self._pieces,
                "piece_counts": self._piece_counts, "map_count": self._pieces_of,
            }  # fmt: skip
        self.emit(self.third, params.remove_duplicates, walked)
        self.ready(self.accumulate, self.fused, params.remove_duplicates)

    def _prepare_sums(self) -> None:
        """The cluster map and the walk over the triangles that fills it."""
        if self.accumulate == "slabs":
            self.slabs = slabs.add_slabs(
                self, self._upload, self.params, self.first, self.fused, self.pieces
            )
            self.sums = self.slabs.maps
            return
        chunks, capacity, count = self.params.chunks, self.capacity, self._triangles
        arguments: dict[str, Any] = {
            "points": self.points, "triangles": self._upload.triangles, "triangle_count": count,
        }  # fmt: skip
        if self.floats:
            self.sums = self.allocate("maps", (chunks, capacity, 16), np.float32)
            arguments |= {"maps": self.sums, "map_count": chunks, "capacity": capacity}
            if self.fused:
                arguments |= self.pieces(chunks)
            name = _PREFIX + ("geometry_fused" if self.fused else "geometry_accumulate")
            items, local = chunks, 1
        else:
            self.sums = self.allocate("sums", (capacity, SUM_LANES), np.int64)
            self._scale = self._fixed_point_scale()
            self.fill(self.first, self.sums, 0)
            arguments |= {"sums": self.sums, "scale": (*self._scale, 0)}
            name = _PREFIX + "geometry_fixed_point"
            items, local = count, None
        self.add(
            self.program(name).launch(name, items, stage=self.first, local=local, **arguments),
            bytes=POINT * count + self.points.size_bytes + self.sums.size_bytes,
            flops=slabs.WALK_FLOPS * count,
        )

    def _hold_border(self) -> None:
        """Border edges add the planes upright on their triangles to the cells of their ends."""
        edges, count = self.upload("edges", self.border, np.uint32, (None, 3)), len(self.border)
        arguments: dict[str, Any] = {
            "points": self.points, "edges": edges, "edge_count": count, "heaviness": HEAVINESS,
        }  # fmt: skip
        if self.floats:
            name, items = _PREFIX + "border_add", self.params.chunks
            arguments |= {"maps": self.sums, "map_count": items, "capacity": self.capacity}
        else:
            name, items = _PREFIX + "border_fixed_point", count
            arguments |= {"sums": self.sums, "scale": (*self._scale, 0)}
        local = 1 if self.floats else None
        self.add(
            self.program(name).launch(name, items, stage=self.first, local=local, **arguments),
            bytes=POINT * count,
            flops=80 * count,
        )

    def pieces(self, count: int) -> dict[str, Buffer]:
        """Room for the survivors that a walk in `count` shares notes."""
        self._pieces_of = count
        self._pieces = self.allocate("pieces", 3 * self._triangles + 4 * count, np.uint32)
        self._piece_counts = self.allocate("piece_counts", count, np.uint32)
        return {"pieces": self._pieces, "piece_counts": self._piece_counts}

    def _fixed_point_scale(self) -> tuple[float, float, float]:
        """Powers of two for A, b and positions, as large as sums of all triangles in one cell allow.

        The bound comes from counts of triangles by exponent, which no order of the triangles changes.
        """
        device, triangles = self.device, max(self._triangles, 1)
        self.place()
        chunks = chunk_count(device, triangles)
        exponents = device.allocate("exponents", (chunks, 256), np.uint32)
        self._upload.program.launch(
            "quadric_clustering_setup_exponents", chunks, stage="size", local=chunk_local(device),
            points=self.points, triangles=self._upload.triangles, exponents=exponents,
            triangle_count=self._triangles, chunk_count=chunks,
        )(Timeline())  # fmt: skip
        counts = device.read(exponents).sum(0, dtype=np.float64)
        border = self.border if self.params.holds_border else NO_EDGES
        squares = squares_by_exponent(self.grid.points(self._mesh.positions[border[:, :2]]))
        return fixed_point_scale(counts, self.grid, self._triangles, squares)

    def _prepare_solve(self) -> None:
        """Pass 2: representatives of all occupied cells."""
        solve: dict[str, Any] = {
            "state": self.state,
            "solved": self.solved,
            "chunk_sums": self.chunk_sums,
            "capacity": self.capacity,
            "limits": self.limits,
            **placing(self.grid, self.params),
        }
        if self.floats:
            solve |= {"maps": self.sums, "map_count": self.params.chunks}
        else:
            solve |= {"sums": self.sums, "inverse_scale": (*(1 / s for s in self._scale), 0)}
        kernel = "fragment_solve" if self.floats else "fragment_solve_fixed_point"
        self.add(
            self.launch(_PREFIX + kernel, self.capacity, "pass_2", **solve),
            bytes=self.sums.size_bytes,
            flops=90 * self.occupied,
        )

    def check(self) -> Check:
        """Same triangles as the reference, and each representative as deep in its planes, in cells."""
        return verdict(self.result()[0], simplify(self._mesh, self.params, self._upload.warp))

    def read_counts(self, counts: Sequence[Buffer]) -> Sequence[NDArray[np.uint32]]:
        """As every clustering's; the same wait tells how representatives were placed."""
        *found, solved = super().read_counts((*counts, self.solved))
        self._kinds = solved[: self.occupied, 3].astype(np.intp)
        return found

    def more_counters(self) -> Mapping[str, int | float]:
        """As every clustering's, and how the used cells' representatives were placed."""
        self.live()
        placed = np.bincount(self._kinds, minlength=len(KINDS) + 1)[1:]
        kinds = {f"placed_{kind}": int(n) for kind, n in zip(KINDS, placed, strict=True)}
        return {**super().more_counters(), **kinds}
