"""A clustering whose vertices go to the nodes of a tree: triangles of a cut, its used nodes, and the maps to them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from lodbench.kernels.cluster.clustering import Clustering
from lodbench.kernels.opencl import Buffer, Launch, Timeline
from lodbench.kernels.stages.scan import chunk_count
from lodbench.kernels.subject import POINT, WORD

NO_TRIANGLE = 0xFFFFFFFF


class Nodes(Clustering):
    """What both octrees share once their cut has given each vertex a node.

    Attributes:
        vertex_nodes: uint32, (n,), of each vertex.
    """

    vertex_nodes: Buffer
    _piece_counts: Buffer

    def _prepare_count(self) -> Callable[[], int]:
        """Counts the triangles that `vertex_nodes` leave."""
        device, count = self.device, self._triangles
        chunks = chunk_count(device, count)
        self._piece_counts = self.allocate("piece_counts", chunks, np.uint32)
        name, more, slots = "cluster_search_survivors", {}, None
        if self.params.remove_duplicates:
            slot_count = 2 << max(count, 1).bit_length()
            slots = device.allocate("slots", slot_count, np.uint32)
            name = "cluster_search_distinct"
            more: dict[str, Any] = {"slots": slots, "slot_mask": slot_count - 1}
        counting = self.launch(
            name, count, "cut", cell_ids=self.vertex_nodes, triangles=self._upload.triangles,
            survivors=self._piece_counts, stride=1, sample_count=count, **more,
        )  # fmt: skip

        def left() -> int:
            if slots is not None:
                device.fill(Timeline(), "cut", slots, NO_TRIANGLE)
            counting(Timeline())
            return int(device.read(self._piece_counts).sum(dtype=np.int64))

        return left

    def _add_triangles(self, cleared: str) -> None:
        """The triangles whose corners lie in three nodes, and which nodes these use; `emit` joins what they note.

        Args:
            cleared: the stage in which the marks of used nodes are cleared.
        """
        count = self._triangles
        used = self.allocate("used", self.capacity, np.uint8)
        pieces = self.allocate("pieces", (count, 3), np.uint32)
        self._walked = {
            "kernel": "octree_cut_join", "pieces": pieces, "piece_counts": self._piece_counts,
        }  # fmt: skip
        self.fill(cleared, used, 0)
        self.add(
            self.launch(
                "octree_cut_triangles", count, "pass_3", nodes=self.vertex_nodes,
                triangles=self._upload.triangles, pieces=pieces, piece_counts=self._piece_counts,
                used=used, triangle_count=count,
            ),
            bytes=POINT * count + WORD * self._vertices,
        )  # fmt: skip
        self.add(
            self.launch(
                "octree_cut_used", self.capacity, "pass_3", used=used, solved=self.solved,
                chunk_sums=self.chunk_sums, node_count=self.capacity,
            )
        )  # fmt: skip

    def mapping(self) -> tuple[Launch, Buffer]:
        result = self.device.allocate("vertex_map", self._vertices, np.uint32)
        launch = self.launch(
            "octree_cut_map", self._vertices, "vertex_map", nodes=self.vertex_nodes,
            new_ranks=self.new_ranks, vertex_map=result, vertex_count=self._vertices,
        )  # fmt: skip
        return launch, result
