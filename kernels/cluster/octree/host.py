"""Clustering on an octree on a device: the tree, its sums from the finest cells up, and the cut."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.octree.params import MAX_LEVELS, Params
from lodbench.kernels.cluster.octree.search import find_limit
from lodbench.kernels.cluster.octree.tree import Tree
from lodbench.kernels.cluster.octree.verdict import verdict
from lodbench.kernels.cluster.unchanged import Unchanged
from lodbench.kernels.cluster.upload import Upload
from lodbench.kernels.opencl import Buffer, Device, Timeline
from lodbench.kernels.stages.scan import chunk_count
from lodbench.kernels.subject import POINT, WORD
from lodbench.kernels.system import Check
from lodbench.kernels.targets import CLOSE, missed

RULES = {"total": 0, "rms": 1, "maximum": 2}
NAMES = ("vertex", "tree", "geometry", "fragment", "cut", "distance")
FILES = tuple(f"cluster/octree/{name}.cl" for name in NAMES)
SUMS = 16  # floats of a node
FINER = 1.6  # finest cells along an axis, at least, for each that a uniform grid would need


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> Octree | Unchanged:
    """The mesh uploaded, the tree built, the threshold found, and a frame ready to run; all triangles: the mesh itself.

    Where `levels` is not given and the finest cells leave too few triangles, finer ones are tried.

    Raises:
        Unsupported: no room.
    """
    upload = Upload(device, mesh, FILES)
    asked = params.triangles(mesh.triangle_count)
    if asked is not None and 0 < mesh.triangle_count <= asked:
        counters = {
            "vertices_in": mesh.vertex_count, "triangles_in": mesh.triangle_count,
            "counting_passes": 0, **missed(asked, mesh.triangle_count),
        }  # fmt: skip
        return Unchanged(device, mesh, upload.positions, upload.triangles, upload.setup, counters)
    if params.levels is not None or asked is None:
        return Octree(upload, params, asked)
    for levels in range(guessed_levels(upload, asked), MAX_LEVELS + 1):
        made = Octree(upload, replace(params, levels=levels), asked)
        if made.left >= CLOSE * asked:
            break
    return made  # pyright: ignore[reportPossiblyUnboundVariable]


def guessed_levels(upload: Upload, target: int) -> int:
    """Levels whose cells are 1.6 to 3.2 times narrower than those of a uniform grid for so many triangles."""
    extents = upload.high - upload.low
    x, y, z = extents / max(float(extents.max()), 1e-300)
    area = max(1.4 * (x * y + y * z + z * x), 0.05)
    along = math.sqrt(max(target, 1) / (2.4 * area))
    return min(max(math.ceil(math.log2(FINER * max(along, 1))), 2), MAX_LEVELS)


class Octree(Tree):
    """See `lodbench.kernels.cluster.octree`.

    ```
    state     uint  [4]                     [0]: nodes
    points    float [4 * vertices]          x y z in units of the finest cell edge, bits of the rank of the finest cell
    nodes     uint  [vertices]              the node that the cut gives a vertex
    centres   float [4 * nodes]             the node's cell: centre and edge; finest level first, the root last
    sums      float [16 * nodes]            quadric, corners, about that centre
    solved    float [4 * nodes]             representative, kind
    errors    float [nodes]                 what the cut compares
    ```

    Attributes:
        limit: the cut's threshold, as errors are.
        left: triangles counted where a number of them was asked for, else -1.
        passes: how often was counted.
    """

    params: Params  # pyright: ignore[reportIncompatibleVariableOverride]

    def __init__(self, upload: Upload, params: Params, asked: int | None = None) -> None:
        super().__init__(upload, params)
        self.asked, self.left, self.passes = asked, -1, 0
        tree = len(self._steps)
        self._prepare_sums()
        self._prepare_solve()
        with self.setup.host("search"):
            self._run(tree)
            self._find_limit()
        self._prepare_cut()
        self.compact("pass_3")
        self.emit("pass_3", walked=self._walked)
        self.ready(params.measured)

    def _prepare_sums(self) -> None:
        """The finest cells' quadrics. Whatever else adds to them is one more launch on `maps`."""
        chunks, leaves, count = self.params.chunks, self.occupied, self._triangles
        self.maps = self.allocate("maps", (chunks, max(leaves, 1), SUMS), np.float32)
        name, grid = "octree_geometry_add", self.grid.arguments
        self.add(
            self.program(name).launch(
                name, chunks, stage="pass_1", local=1, points=self.points,
                triangles=self._upload.triangles, maps=self.maps, per_axis=grid["per_axis"],
                cells=grid["cells"], map_count=chunks, leaf_count=leaves, triangle_count=count,
            ),
            bytes=POINT * count + self.points.size_bytes + self.maps.size_bytes,
            flops=160 * count,
        )  # fmt: skip

    def _prepare_solve(self) -> None:
        """Sums, representatives and errors of all nodes, from the finest level to the root."""
        rule, whole = RULES[self.params.measured], self.params.whole
        self.sums = self.allocate("sums", (self.capacity, SUMS), np.float32)
        self.solved = self.allocate("solved", (self.capacity, 4), np.float32)
        self.errors = self.allocate("errors", self.capacity, np.float32)
        shared = {
            "centres": self.centres, "sums": self.sums, "solved": self.solved,
            "errors": self.errors, "rule": rule,
        }  # fmt: skip
        self.add(
            self.launch(
                "octree_fragment_leaves", self.occupied, "pass_2", maps=self.maps,
                map_count=self.params.chunks, node_count=self.occupied, **shared,
            ),
            bytes=self.maps.size_bytes,
            flops=120 * self.occupied,
        )  # fmt: skip
        levels = [
            (int(self.level_nodes[level]), {
                "firsts": self.firsts, "first_node": int(self.starts[level]),
                "child_end": int(self.starts[level]), "node_count": int(self.level_nodes[level]),
            })
            for level in reversed(range(self.levels))
        ]  # fmt: skip
        for count, of_level in levels:
            self.add(
                self.launch(
                    "octree_fragment_parents", count, "pass_2", whole=int(whole),
                    **of_level, **shared,
                ),
                bytes=4 * SUMS * count,
                flops=120 * count,
            )  # fmt: skip
        if self.params.measured == "maximum":
            bits = self.errors.view((self.capacity,), np.uint32)
            self.add(
                self.launch(
                    "octree_distance_add", self._triangles, "pass_2", points=self.points,
                    triangles=self._upload.triangles, parents=self.parents, solved=self.solved,
                    errors=bits, triangle_count=self._triangles,
                )
            )  # fmt: skip
            for count, of_level in levels if whole else ():
                self.add(
                    self.launch("octree_distance_raise", count, "pass_2", errors=bits, **of_level)
                )

    def _find_limit(self) -> None:
        """The threshold: what was asked for in the unit of the errors, or by counting what thresholds leave."""
        device, leaves = self.device, self.occupied
        self.cut = self.allocate("cut", max(leaves, 1), np.uint32)
        self.vertex_nodes = self.allocate("nodes", self._vertices, np.uint32)
        self._piece_counts = self.allocate(
            "piece_counts", chunk_count(device, self._triangles), np.uint32
        )
        self._cutting = self.launch(
            "octree_cut_leaves", leaves, "cut", parents=self.parents, errors=self.errors,
            cut=self.cut, limit=0.0, leaf_count=leaves,
        )  # fmt: skip
        self._placing = self.launch(
            "octree_cut_vertices", self._vertices, "cut", points=self.points, cut=self.cut,
            nodes=self.vertex_nodes, vertex_count=self._vertices,
        )  # fmt: skip
        self.area = float(device.read(self.sums)[-1, [0, 3, 5]].astype(np.float64).sum())
        diagonal = float(np.linalg.norm(self._upload.high - self._upload.low)) / self.grid.edge
        self.scale = 1 / max(diagonal, 1e-30)
        if self.params.measured == "total":
            self.scale /= math.sqrt(max(self.area, 1e-30))
        if self.asked is None:
            self.limit = float(np.float32(min(self.params.error / self.scale, 3e38)))
            return
        counting = self.launch(
            "octree_cut_count", self._triangles, "cut", nodes=self.vertex_nodes,
            triangles=self._upload.triangles, piece_counts=self._piece_counts,
            triangle_count=self._triangles,
        )  # fmt: skip

        def count(limit: float) -> int:
            self._cutting.set(limit=limit)
            for launch in (self._cutting, self._placing, counting):
                launch(Timeline())
            return int(device.read(self._piece_counts).sum(dtype=np.int64))

        most = float(device.read(self.errors).max(initial=0))
        self.limit, self.left, self.passes = find_limit(count, self.asked, most)

    def _prepare_cut(self) -> None:
        """The nodes that vertices go to, and which of them a surviving triangle uses."""
        self._cutting.set(limit=self.limit)
        self.add(self._cutting, bytes=2 * self.cut.size_bytes)
        self.add(self._placing, bytes=2 * WORD * self._vertices)
        self._add_triangles("cut")

    def read_tree(self) -> dict[str, Any]:
        """Of the last frame: sums and errors of all nodes, for tests and pictures."""
        self.live()
        kept: dict[str, Buffer] = {
            "sums": self.sums, "errors": self.errors, "centres": self.centres,
            "parents": self.parents,
        }  # fmt: skip
        return {name: self.device.read(buffer) for name, buffer in kept.items()}

    def check(self) -> Check:
        """See `verdict`."""
        return verdict(self)  # pyright: ignore[reportArgumentType]

    def more_counters(self) -> Mapping[str, int | float]:
        """As every clustering's, with `levels`, `nodes` and the threshold as a share of the diagonal.

        `nodes_level_0` is the root's level; `used_level_0` and so on are the output's vertices by level.
        """
        solved, centres = self.device.read(self.solved), self.device.read(self.centres)
        edges = centres[: int(self.level_nodes.sum())][
            solved[: int(self.level_nodes.sum()), 3] > 0, 3
        ]
        used = {
            f"used_level_{level}": int((edges == 2.0 ** (self.levels - level)).sum())
            for level in range(self.levels + 1)
        }
        counters = {
            **super().more_counters(), "levels": self.levels, "nodes": int(self.level_nodes.sum()),
            "threshold": max(self.limit * self.scale, 0.0), **used,
        }  # fmt: skip
        if self.asked is not None:
            counters |= missed(self.asked, self.live()[1])
            counters["counting_passes"] = self.passes
        return counters
