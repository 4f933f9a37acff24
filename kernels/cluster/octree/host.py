"""Clustering on an octree on a device: the tree, its sums from the finest cells up, and the cut."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.octree.params import Params
from lodbench.kernels.cluster.octree.search import FINER, MOST_CELLS, find_limit, uniform_cells
from lodbench.kernels.cluster.octree.tree import HEAVY, Tree, launched
from lodbench.kernels.cluster.octree.verdict import verdict
from lodbench.kernels.cluster.prepare import unchanged
from lodbench.kernels.cluster.quadric_clustering.params import HEAVINESS
from lodbench.kernels.cluster.unchanged import Unchanged
from lodbench.kernels.cluster.upload import Upload
from lodbench.kernels.opencl import Buffer, Device, Timeline
from lodbench.kernels.subject import POINT, WORD
from lodbench.kernels.system import Check
from lodbench.kernels.targets import CLOSE, missed

RULES = {"total": 0, "rms": 1, "maximum": 2}
NAMES = ("vertex", "tree", "geometry", "border", "fragment", "boxes", "cut", "distance")
FILES = tuple(f"cluster/octree/{name}.cl" for name in NAMES)
SUMS = 16  # floats of a node
OF_A_BOX = 4  # kinds of boxes' representatives are more


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> Octree | Unchanged:
    """The mesh uploaded, the tree built, the threshold found, and a frame ready to run; all triangles: the mesh itself.

    Where `levels` is not given and the finest cells leave too few triangles, finer ones are tried.

    Raises:
        Unsupported: no room.
    """
    upload = Upload(device, mesh, FILES, borders=params.uses_border)
    asked = params.triangles(mesh.triangle_count)
    if asked is not None and 0 < mesh.triangle_count <= asked:
        return unchanged(upload, asked, params.remove_duplicates, FILES)
    if params.levels is not None or asked is None:
        return Octree(upload, params, params.grid_cells, asked)
    cells = FINER * uniform_cells(upload, asked)
    while True:
        cells = min(max(cells, 4.0), float(MOST_CELLS))
        made = Octree(upload, params, cells, asked)
        if made.left >= CLOSE * asked or cells == MOST_CELLS:
            return made
        cells *= 1.5


class Octree(Tree):
    """See `lodbench.kernels.cluster.octree`.

    ```
    state     uint  [4]                     [0]: nodes, and kept border vertices
    points    float [4 * vertices]          x y z in units of the finest cell edge, bits of the rank of the finest cell
    nodes     uint  [vertices]              the node that the cut gives a vertex
    centres   float [4 * nodes]             the node's cell: centre and edge; finest level first, the root last
    sums      float [16 * nodes]            quadric, corners, about that centre
    solved    float [4 * nodes]             representative, kind; a box's in its first child's row
    errors    float [nodes]                 what the rule says of a node
    costs     float [nodes]                 what the vertices of a node cost at the least
    joins     uint  [nodes]                 the node that it is joined to
    ```

    Attributes:
        limit: the largest error, as errors are.
        left: triangles counted where a number of them was asked for, else -1.
        passes: how often was counted.
    """

    params: Params  # pyright: ignore[reportIncompatibleVariableOverride]

    def __init__(
        self, upload: Upload, params: Params, cells: float, asked: int | None = None
    ) -> None:
        super().__init__(upload, params, cells)
        self.asked, self.left, self.passes = asked, -1, 0
        tree = len(self._steps)
        self._prepare_sums()
        if params.holds_border and len(self.border):
            self._hold_border()
        self._prepare_solve()
        self._prepare_boxes()
        with self.setup.host("search"):
            self._run(tree)
            self._find_limit()
        self._prepare_cut()
        self.compact("pass_3")
        self.emit("pass_3", params.remove_duplicates, self._walked)
        self.ready(params.measured, params.boxed, params.border, params.remove_duplicates)

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

    def _hold_border(self) -> None:
        """Border edges add the planes upright on their triangles to the finest cells of their ends."""
        edges, count = self.upload("edges", self.border, np.uint32, (None, 3)), len(self.border)
        name, grid, chunks = "octree_border_add", self.grid.arguments, self.params.chunks
        self.add(
            self.program(name).launch(
                name, chunks, stage="pass_1", local=1, points=self.points, edges=edges,
                maps=self.maps.view((self.maps.size_bytes // WORD,), np.float32),
                per_axis=grid["per_axis"], cells=grid["cells"], heaviness=HEAVINESS,
                map_count=chunks, leaf_count=self.occupied, edge_count=count,
            ),
            bytes=POINT * count,
        )  # fmt: skip

    def _prepare_solve(self) -> None:
        """Sums, representatives and errors of all nodes, from the finest level to the root."""
        rule = RULES[self.params.measured]
        self.sums = self.allocate("sums", (self.nodes, SUMS), np.float32)
        self.solved = self.allocate("solved", (self.capacity, 4), np.float32)
        self.errors = self.allocate("errors", self.nodes, np.float32)
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
        self._levels = [
            (count, {
                "firsts": self.firsts, "starts": self._starts, "level": level, "last": last,
                "node_count": int(self.level_nodes.sum()),
            })
            for count, level, last in launched(self.level_nodes)
        ]  # fmt: skip
        for count, of_level in self._levels:
            self.add(
                self.launch("octree_fragment_parents", count, "pass_2", **of_level, **shared),
                bytes=4 * SUMS * count // HEAVY,
                flops=120 * count // HEAVY,
            )
        if self.params.measured == "maximum":
            self.add(
                self.launch(
                    "octree_distance_add", self._triangles, "pass_2", points=self.points,
                    triangles=self._upload.triangles, parents=self.parents, solved=self.solved,
                    errors=self.errors.view((self.nodes,), np.uint32),
                    triangle_count=self._triangles,
                )
            )  # fmt: skip

    def _prepare_boxes(self) -> None:
        """What children are joined to, from the finest level to the root."""
        self.costs = self.allocate("costs", self.nodes, np.float32)
        self.joins = self.allocate("joins", self.nodes, np.uint32)
        self._choosing = [
            self.launch(
                "octree_boxes_choose", count, "boxes", centres=self.centres, sums=self.sums,
                errors=self.errors, solved=self.solved, costs=self.costs, joins=self.joins,
                limit=0.0, rule=RULES[self.params.measured], boxed=int(self.params.boxed),
                leaf_count=self.occupied, **of_level,
            )
            for count, of_level in self._levels
        ]  # fmt: skip

    def _find_limit(self) -> None:
        """The threshold: what was asked for in the unit of the errors, or by counting what thresholds leave."""
        device, leaves = self.device, self.occupied
        self.cut = self.allocate("cut", max(leaves, 1), np.uint32)
        self.vertex_nodes = self.allocate("nodes", self._vertices, np.uint32)
        self._cutting = [
            self.launch(
                "octree_cut_leaves", leaves, "cut", parents=self.parents, joins=self.joins,
                cut=self.cut, leaf_count=leaves,
            ),
            self.launch(
                "octree_cut_vertices", self._vertices, "cut", points=self.points, cut=self.cut,
                nodes=self.vertex_nodes, vertex_count=self._vertices,
            ),
        ]  # fmt: skip
        if len(self.kept):
            kept, nodes = self.upload("kept", self.kept, np.uint32), int(self.level_nodes.sum())
            self._kept = {"kept": kept, "occupied": nodes, "kept_count": len(self.kept)}
            self._cutting.append(
                self.launch(
                    "octree_cut_keep", len(self.kept), "cut", kept=kept, nodes=self.vertex_nodes,
                    solved=self.solved, first=nodes, kept_count=len(self.kept),
                )
            )  # fmt: skip
        self.area = float(device.read(self.sums)[-1, [0, 3, 5]].astype(np.float64).sum())
        diagonal = float(np.linalg.norm(self._upload.high - self._upload.low)) / self.grid.edge
        self.scale = 1 / max(diagonal, 1e-30)
        if self.params.measured == "total":
            self.scale /= math.sqrt(max(self.area, 1e-30))
        counting = self._prepare_count()
        if self.asked is None:
            self._set_limit(float(np.float32(min(self.params.error / self.scale, 1e18))))
            return

        def count(limit: float) -> int:
            self._set_limit(limit)
            for launch in (*self._choosing, *self._cutting):
                launch(Timeline())
            return counting()

        most = float(device.read(self.errors).max(initial=0))
        limit, self.left, self.passes = find_limit(count, self.asked, most)
        self._set_limit(limit)

    def _set_limit(self, limit: float) -> None:
        self.limit = limit
        for launch in self._choosing:
            launch.set(limit=limit)

    def _prepare_cut(self) -> None:
        """The nodes that vertices go to, and which of them a surviving triangle uses."""
        for launch in self._choosing:
            self.add(launch)
        for launch in self._cutting:
            self.add(launch)
        self._add_triangles("cut")

    def read_tree(self) -> dict[str, Any]:
        """Of the last frame: sums and errors of all nodes, for tests and pictures."""
        self.live()
        kept: dict[str, Buffer] = {
            "sums": self.sums, "errors": self.errors, "centres": self.centres,
            "parents": self.parents, "costs": self.costs, "joins": self.joins,
        }  # fmt: skip
        return {name: self.device.read(buffer) for name, buffer in kept.items()}

    def edges(self) -> NDArray[np.float32]:
        """Of the largest cube in each output vertex's cell, in finest cells, (n,); 1 of a kept border vertex."""
        self.live()
        used = self.device.read(self.solved)[:, 3] > 0
        edges = np.ones(self.capacity, np.float32)
        edges[: self.nodes] = self.device.read(self.centres)[:, 3]
        return edges[used]

    def check(self) -> Check:
        """See `verdict`."""
        return verdict(self)  # pyright: ignore[reportArgumentType]

    def more_counters(self) -> Mapping[str, int | float]:
        """As every clustering's, with `levels`, `nodes` and the threshold as a share of the diagonal.

        `used_level_0`, the root's, and so on are the output's vertices by the level of the largest cube in their cells;
        `used_boxes` of them are those of boxes of several.
        """
        edges = self.edges()
        used = {
            f"used_level_{level}": int((edges == 2.0 ** (self.levels - level)).sum())
            for level in range(self.levels + 1)
        }
        nodes = int(self.level_nodes.sum())
        kinds = self.device.read(self.solved)[:nodes, 3]
        used["used_boxes"] = int((kinds > OF_A_BOX).sum())
        counters = {
            **super().more_counters(), "levels": self.levels, "nodes": nodes,
            "threshold": max(self.limit * self.scale, 0.0), **used,
        }  # fmt: skip
        if self.asked is not None:
            counters |= missed(self.asked, self.live()[1])
            counters["counting_passes"] = self.passes
        return counters
