"""The nodes of an octree on a device: occupied cells of all levels, sorted along the Morton curve."""

from __future__ import annotations

import numpy as np

from lodbench.kernels.cluster.octree.nodes import Nodes
from lodbench.kernels.cluster.octree.params import MAX_LEVELS, Params
from lodbench.kernels.cluster.upload import Upload
from lodbench.kernels.opencl import Timeline
from lodbench.kernels.stages.scan import chunk_count
from lodbench.kernels.subject import POINT

LEVELS = MAX_LEVELS + 1  # with the root's


class Tree(Nodes):
    """A clustering whose cells are the nodes of an octree; what is left to a system are their sums and the cut.

    Attributes:
        levels: of the finest grid.
        level_nodes: nodes of each level, the root's level first.
        starts: first node of each level, in that order; the finest level comes first among the nodes.
    """

    def __init__(self, upload: Upload, params: Params) -> None:
        super().__init__(upload, params, None)  # pyright: ignore[reportArgumentType]
        self.levels = params.grid_cells.bit_length() - 1
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
        marks = self.allocate("marks", 64 * words_count, np.uint8)
        words = self.allocate("words", (words_count, 2), np.uint64)
        found = self.allocate("found", 4, np.uint32)
        place = {
            "positions": self._upload.positions,
            "vertex_count": self._vertices,
            **self.grid.arguments,
        }
        rank = {"words": words, "chunk_sums": self.chunk_sums, "word_count": words_count}
        eights = marks.view((words_count, 8), np.uint64)
        self.fill("tree", marks, 0)
        self.add(self.launch("octree_vertex_mark", self._vertices, "tree", marks=marks, **place))
        self.add(self.launch("cluster_cells_count", words_count, "tree", marks=eights, **rank))
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
        self.capacity = max(int(self.level_nodes.sum()), 1)
        ends = np.cumsum(self.level_nodes[::-1])[::-1]
        self.starts = ends - self.level_nodes
        first = np.zeros(LEVELS, np.uint32)
        first[: self.levels + 1] = self.starts
        starts = self.upload("starts", first, role="scratch")
        self.state = self.upload(
            "state", np.array([self.level_nodes.sum(), 0, 0, 0], np.uint32), role="scratch"
        )
        self.centres = self.allocate("centres", (self.capacity, 4), np.float32)
        self.parents = self.allocate("parents", self.capacity, np.uint32)
        self.firsts = self.allocate("firsts", self.capacity, np.uint32)
        self.add(
            self.launch(
                "octree_tree_link", leaves, "tree", chunk_counts=counts, starts=starts,
                centres=self.centres, parents=self.parents, firsts=self.firsts, **shared,
            ),
            bytes=self.centres.size_bytes + 2 * self.parents.size_bytes,
        )  # fmt: skip
        self._run(before + 1)
