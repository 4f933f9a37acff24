"""The nodes of an octree on a device: occupied cells of all levels, sorted along the Morton curve."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.cluster.octree.nodes import Nodes
from lodbench.kernels.cluster.octree.params import MAX_LEVELS, Params
from lodbench.kernels.cluster.upload import Upload
from lodbench.kernels.opencl import Timeline
from lodbench.kernels.stages.scan import chunk_count
from lodbench.kernels.subject import POINT

LEVELS = MAX_LEVELS + 1  # with the root's
FEW = 256  # parents of a level that one item does sooner than another launch
HEAVY = 8  # rows of parents are worth so many others


def levels_of(grid: Grid, params: Params) -> int:
    """Halvings of a cube of 2^levels cells until the finest ones are those of this grid."""
    return max((max(grid.counts) - 1).bit_length(), params.levels or 1)


def launched(level_nodes: NDArray[np.int64]) -> Iterator[tuple[int, int, int]]:
    """Of the levels above the finest one, which go in one launch: rows, the finest and the coarsest of them."""
    level = len(level_nodes) - 2
    while level >= 0 and level_nodes[level] > FEW:
        yield HEAVY * int(level_nodes[level]), level, level
        level -= 1
    if level >= 0:
        yield 1, level, 0


class Tree(Nodes):
    """A clustering whose cells are the nodes of an octree; what is left to a system are their sums and the cut.

    Attributes:
        cells: of the finest grid along the longest box edge.
        levels: of the finest grid.
        nodes: rows of what is kept per node, at least 1.
        level_nodes: nodes of each level, the root's level first.
        starts: first node of each level, in that order; the finest level comes first among the nodes.
    """

    def __init__(self, upload: Upload, params: Params, cells: float) -> None:
        super().__init__(upload, params, None)
        self.cells = cells
        self.cell_grid = self.grid = Grid.over(*upload.box, cells)
        self.levels = levels_of(self.grid, params)
        with self.setup.host("size"):
            self._find_leaves()
            self._find_nodes()

    def _run(self, steps: int) -> None:
        """The frame's steps from this one on, once."""
        for step in self._steps[steps:]:
            step.enqueue(Timeline())

    def _find_leaves(self) -> None:
        """The occupied finest cells, and which of them each vertex is in."""
        x, y, z = (n - 1 for n in self.grid.counts)
        spread = [sum((n >> bit & 1) << 3 * bit for bit in range(LEVELS)) for n in (x, y, z)]
        words_count = (spread[0] + 2 * spread[1] + 4 * spread[2]) // 64 + 1
        chunks = chunk_count(self.device, max(self._vertices, self._triangles, words_count))
        self.chunk_sums = self.allocate("chunk_sums", chunks, np.uint32)
        words = self.allocate("words", (words_count, 2), np.uint64)
        found = self.allocate("found", 4, np.uint32)
        place = {
            "positions": self._upload.positions,
            "vertex_count": self._vertices,
            **self.grid.arguments,
        }
        rank = {"words": words, "chunk_sums": self.chunk_sums, "word_count": words_count}
        bits = words.view((words_count, 4), np.uint32)
        self.fill("tree", words, 0)
        self.add(self.launch("octree_vertex_mark", self._vertices, "tree", bits=bits, **place))
        self.add(self.launch("octree_tree_leaves", words_count, "tree", **rank))
        self.add(self.launch("cluster_cells_rank", words_count, "tree", state=found, **rank))
        self._run(0)
        self.occupied = int(self.device.read(found)[0])
        self.points = self.allocate("points", (self._vertices, 4), np.float32)
        self.codes = self.allocate("codes", max(self.occupied, 1), np.uint32)
        self.add(
            self.launch(
                "octree_vertex_place", self._vertices, "tree", words=words, points=self.points,
                capacity=max(self.occupied, 1), **place,
            ),
            bytes=POINT * self._vertices + self.points.size_bytes,
        )  # fmt: skip
        self.add(
            self.launch(
                "octree_tree_codes", words_count, "tree", words=words, codes=self.codes,
                word_count=words_count, leaf_count=self.occupied,
            )
        )  # fmt: skip
        self._run(4)

    def _find_nodes(self) -> None:
        """The cells of the coarser levels, and who belongs to whom."""
        before = len(self._steps)
        leaves = self.occupied
        shared = {"codes": self.codes, "finest": self.levels, "leaf_count": leaves}
        counts = self.allocate(
            "chunk_counts", (chunk_count(self.device, leaves), LEVELS), np.uint32
        )
        self.add(self.launch("octree_tree_count", leaves, "tree", chunk_counts=counts, **shared))
        self._run(before)
        self.level_nodes = self.device.read(counts).sum(0, dtype=np.int64)[: self.levels + 1]
        nodes = int(self.level_nodes.sum())
        self.capacity = max(nodes + len(self.kept), 1)
        ends = np.cumsum(self.level_nodes[::-1])[::-1]
        self.starts = ends - self.level_nodes
        first = np.zeros(LEVELS, np.uint32)
        first[: self.levels + 1] = self.starts
        self._starts = self.upload("starts", first, role="scratch")
        self.state = self.upload(
            "state", np.array([nodes + len(self.kept), 0, 0, 0], np.uint32), role="scratch"
        )
        self.nodes = max(nodes, 1)
        self.centres = self.allocate("centres", (self.nodes, 4), np.float32)
        self.parents = self.allocate("parents", self.nodes, np.uint32)
        self.firsts = self.allocate("firsts", self.nodes, np.uint32)
        self.add(
            self.launch(
                "octree_tree_link", leaves, "tree", chunk_counts=counts, starts=self._starts,
                centres=self.centres, parents=self.parents, firsts=self.firsts, **shared,
            ),
            bytes=self.centres.size_bytes + 2 * self.parents.size_bytes,
        )  # fmt: skip
        self._run(before + 1)
