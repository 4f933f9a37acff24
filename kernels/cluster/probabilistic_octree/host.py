"""The published octree on a device: the table, its slots solved, and the cut read from it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.octree.nodes import Nodes
from lodbench.kernels.cluster.octree.search import FINER, find_limit, uniform_cells
from lodbench.kernels.cluster.prepare import unchanged
from lodbench.kernels.cluster.probabilistic_octree import reference
from lodbench.kernels.cluster.probabilistic_octree.params import MAX_LEVELS, Params
from lodbench.kernels.cluster.probabilistic_octree.verdict import verdict
from lodbench.kernels.cluster.unchanged import Unchanged
from lodbench.kernels.cluster.upload import Upload
from lodbench.kernels.opencl import Device, Timeline, Unsupported
from lodbench.kernels.stages.scan import chunk_count
from lodbench.kernels.subject import POINT, WORD
from lodbench.kernels.system import Check
from lodbench.kernels.targets import missed

RULES = {"total": 0, "rms": 1}
WORDS = 14  # of a slot
LEAST_LEVELS = (
    6  # a share of fewer levels is a table of so few slots that hardly a node has its own
)
_PREFIX = "probabilistic_octree_"
FILES = (
    *(f"cluster/probabilistic_octree/{name}.cl" for name in ("geometry", "fragment", "cut")),
    "cluster/octree/cut.cl",
)


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> ProbabilisticOctree | Unchanged:
    """The mesh uploaded, the table built, the threshold found, a frame ready to run; all triangles: the mesh itself.

    Raises:
        Unsupported: no room, or no 64-bit atomics.
    """
    if "cl_khr_int64_base_atomics" not in device.facts.extensions:
        raise Unsupported("needs cl_khr_int64_base_atomics, device has none")
    upload = Upload(device, mesh, FILES)
    asked = params.triangles(mesh.triangle_count)
    if asked is not None and 0 < mesh.triangle_count <= asked:
        return unchanged(upload, asked, params.remove_duplicates, FILES)
    if params.levels is None and asked is not None:
        cells = FINER * uniform_cells(upload, asked)
        levels = math.ceil(math.log2(max(cells, 1)))
        params = replace(params, levels=min(max(levels, LEAST_LEVELS), MAX_LEVELS))
    return ProbabilisticOctree(upload, params, asked)


class ProbabilisticOctree(Nodes):
    """See `lodbench.kernels.cluster.probabilistic_octree`.

    ```
    points    float [4 * vertices]    x y z in units of the finest cell edge, bits of the finest cell's code
    sums      long  [14 * slots]      quadric, corner sum, corners, in units of the node's own edge
    keys      int   [2 * slots]       largest key, largest negative key
    solved    float [4 * slots]       representative, kind
    errors    float [slots]           what the cut compares
    nodes     uint  [vertices]        slot that a vertex goes to
    ```

    Attributes:
        levels: of the finest grid.
        limit: the cut's threshold, as errors are.
        passes: how often was counted for a number of triangles.
    """

    params: Params  # pyright: ignore[reportIncompatibleVariableOverride]

    def __init__(self, upload: Upload, params: Params, asked: int | None = None) -> None:
        super().__init__(upload, params, None)
        self.mesh, self.asked, self.passes = upload.mesh, asked, 0
        self.levels = params.grid_cells.bit_length() - 1
        self.capacity = params.slots
        chunks = chunk_count(self.device, max(self._triangles, self._vertices, self.capacity))
        self.chunk_sums = self.allocate("chunk_sums", chunks, np.uint32)
        self.state = self.upload(
            "state", np.array([self.capacity, 0, 0, 0], np.uint32), role="scratch"
        )
        self._prepare_table()
        with self.setup.host("search"):
            for step in self._steps:
                step.enqueue(Timeline())
            self._find_limit()
        self._prepare_cut()
        self.compact("pass_3")
        self.emit("pass_3", params.remove_duplicates, self._walked)
        self.ready(params.search, params.remove_duplicates)

    def _prepare_table(self) -> None:
        """Quadrics and keys of all levels, then representatives and errors."""
        count, slots, finest = self._triangles, self.capacity, self.levels
        self.points = self.allocate("points", (self._vertices, 4), np.float32)
        self.sums = self.allocate("sums", (slots, WORDS), np.int64)
        self.keys = self.allocate("keys", (slots, 2), np.int32)
        self.solved = self.allocate("solved", (slots, 4), np.float32)
        self.errors = self.allocate("errors", slots, np.float32)
        self.add(
            self.launch(
                _PREFIX + "geometry_place", self._vertices, "pass_1",
                positions=self._upload.positions, points=self.points,
                vertex_count=self._vertices, **self.grid.arguments,
            ),
            bytes=POINT * self._vertices + self.points.size_bytes,
        )  # fmt: skip
        self.fill("pass_1", self.sums, 0)
        self.fill("pass_1", self.keys, np.iinfo(np.int32).min)
        # a third of a triangle is at most a sixth of the box's side squared, times three, and weights reach 2^levels
        reach = math.ceil(math.log2(3 * max(count, 1))) + finest
        scale = 2.0 ** (60 - reach - 2 * finest), 2.0 ** (60 - reach)
        name = _PREFIX + "geometry_add"
        writes = 1 + finest if self.params.construction == "full" else 2
        self.add(
            self.program(name).launch(
                name, count, stage="pass_1", points=self.points,
                triangles=self._upload.triangles, sums=self.sums, keys=self.keys, scale=scale,
                finest=finest, randomised=int(self.params.construction == "randomised"),
                seed=self.params.seed, slot_count=slots, triangle_count=count,
            ),
            bytes=POINT * count + self.points.size_bytes + self.sums.size_bytes,
            flops=3 * 40 * writes * count,
        )  # fmt: skip
        self.add(
            self.launch(
                _PREFIX + "fragment_solve", slots, "pass_2", sums=self.sums,
                keys=self.keys,
                solved=self.solved, errors=self.errors,
                inverse_scale=tuple(1 / s for s in scale), finest=finest,
                rule=RULES[self.params.rule], slot_count=slots,
            ),
            bytes=self.sums.size_bytes,
        )  # fmt: skip

    def _cut_launch(self, search: str, nodes: Any) -> Any:
        return self.launch(
            f"{_PREFIX}cut_{search}", self._vertices, "cut", points=self.points, keys=self.keys,
            errors=self.errors, nodes=nodes, limit=0.0, finest=self.levels, seed=self.params.seed,
            slot_count=self.capacity, vertex_count=self._vertices,
        )  # fmt: skip

    def _find_limit(self) -> None:
        """The threshold: what was asked for in the unit of the errors, or by counting what thresholds leave."""
        device, params = self.device, self.params
        self.vertex_nodes = self.allocate("nodes", self._vertices, np.uint32)
        counting = self._prepare_count()
        self._cutting = self._cut_launch(params.search, self.vertex_nodes)
        diagonal = float(np.linalg.norm(self._upload.high - self._upload.low)) / self.grid.edge
        self.scale = 1 / max(diagonal, 1e-30)
        if params.rule == "total":
            self.scale /= math.sqrt(max(self._area(), 1e-30))
        if self.asked is None:
            self.limit = float(np.float32(min(params.error / self.scale, 3e38)))
            return

        def count(limit: float) -> int:
            self._cutting.set(limit=limit)
            self._cutting(Timeline())
            return counting()

        errors = device.read(self.errors)
        most = float(errors[np.isfinite(errors)].max(initial=0))
        self.limit, _, self.passes = find_limit(count, self.asked, most)

    def _area(self) -> float:
        """Of the mesh, in finest cells."""
        p = self.grid.points(self.mesh.positions).astype(np.float64)[self.mesh.triangles]
        p = p.reshape(-1, 3, 3)
        m = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
        return float(np.linalg.norm(m, axis=1).sum()) / 2

    def _prepare_cut(self) -> None:
        """The slots that vertices go to, and which of them a surviving triangle uses."""
        self._cutting.set(limit=self.limit)
        self.add(self._cutting, bytes=2 * WORD * self._vertices)
        self._add_triangles("pass_3")

    def read_table(self) -> dict[str, Any]:
        """Of the last frame: keys and errors of all slots, and the slot of each vertex."""
        self.live()
        kept = {"keys": self.keys, "errors": self.errors, "nodes": self.vertex_nodes}
        return {name: self.device.read(buffer) for name, buffer in kept.items()}

    def check(self) -> Check:
        """See `verdict`."""
        return verdict(self)  # pyright: ignore[reportArgumentType]

    def disagreement(self) -> float:
        """Share of the vertices that linear and binary search send to different nodes."""
        other = self.device.allocate("nodes", self._vertices, np.uint32)
        launch = self._cut_launch("binary" if self.params.search == "linear" else "linear", other)
        launch.set(limit=self.limit)
        launch(Timeline())
        differ = self.device.read(other) != self.device.read(self.vertex_nodes)
        return float(differ.mean()) if len(differ) else 0.0

    def more_counters(self) -> Mapping[str, int | float]:
        """`keys` written, `slots`, their share of the full tree, and what was lost.

        `collisions` is the share of the keys that met another in their slot, `collisions_predicted` what a uniform
        hash leads to expect; `disagreement` the share of vertices for which binary and linear search differ.
        """
        read, count = self.read_table(), 0
        corners = np.arange(3 * self._triangles)
        codes = self.device.read(self.points)[:, 3].view(np.uint32).astype(np.int64)
        code = codes[self.mesh.triangles].reshape(-1)
        for up in range(self.levels + 1):
            count += len(np.unique(code[reference.written(corners, up, self.params)] >> (3 * up)))
        keys = read["keys"].astype(np.int64)
        alone = int(((keys[:, 0] > 0) & (keys[:, 0] == -keys[:, 1])).sum())
        slots = self.capacity
        counters: dict[str, int | float] = {
            "vertices_in": self._vertices, "triangles_in": self._triangles, "levels": self.levels,
            "full_tree": self.params.full_tree, "slots": slots, "keys": count,
            "storage": slots / self.params.full_tree,
            "collisions": (count - alone) / max(count, 1),
            "collisions_predicted": expected_collisions(count, slots),
            "disagreement": self.disagreement(),
            "threshold": max(self.limit * self.scale, 0.0),
        }  # fmt: skip
        if self.asked is not None:
            counters |= missed(self.asked, self.live()[1])
            counters["counting_passes"] = self.passes
        return counters


def expected_collisions(keys: int, slots: int) -> float:
    """Share of `keys` that a uniform hash brings together with another; the root is among them, in its own slot."""
    hashed, rest = keys - 1, slots - 1
    if hashed < 2:
        return 0.0
    if rest < 2:
        return hashed / keys
    return hashed / keys * -math.expm1((hashed - 1) * math.log1p(-1 / rest))
