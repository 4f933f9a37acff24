"""A clustering whose vertices go to the nodes of a tree: triangles of a cut, its used nodes, and the maps to them."""

from __future__ import annotations

import numpy as np

from lodbench.kernels.cluster.clustering import Clustering
from lodbench.kernels.opencl import Buffer, Timeline
from lodbench.kernels.subject import POINT, WORD


class Nodes(Clustering):
    """What both octrees share once their cut has given each vertex a node.

    Attributes:
        vertex_nodes: uint32, (n,), of each vertex.
    """

    vertex_nodes: Buffer
    _piece_counts: Buffer

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

    def _map(self) -> Buffer:
        result = self.device.allocate("vertex_map", self._vertices, np.uint32)
        self.launch(
            "octree_cut_map", self._vertices, "vertex_map", nodes=self.vertex_nodes,
            new_ranks=self.new_ranks, vertex_map=result, vertex_count=self._vertices,
        )(Timeline())  # fmt: skip
        return result
