"""A last step after the collapses: vertices move to where they fit the input best.

What is left is judged by its distance from the input, of which collapses know only the planes of the mesh as it was.
So centroids of the input's triangles are samples, each goes to the nearest triangle at the vertex that its own went to,
and each vertex is solved for the heights of the samples of its triangles above these, in 3-D. Its neighbours move at the
same time: what they have of a sample is taken from its step, so that the sum of squares does not rise (Jensen). Border
vertices, creases and locked vertices stay, and in each step no vertex moves so far in the plane of a triangle that this
could turn over. Triangles stay what they are.

Source: ours; distances from planes as in Chen & Medioni 1992, as the mesh optimisation of Hoppe et al. 1993 fits
positions to points.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lodbench.kernels.opencl import Buffer
from lodbench.kernels.stages.scan import chunk_count, map_count

if TYPE_CHECKING:
    from lodbench.kernels.cluster.edge_collapse.host import EdgeCollapse

FILES = tuple(
    f"cluster/edge_collapse/{name}.cl" for name in ("fit_sort", "fit_order", "fit_gather", "fit_move")
)
ROOM = 2  # times the target: where more triangles are left, or half of all, vertices stay
EVERY = 2, 1  # of so many samples of a vertex one counts, step by step


class Fit:
    """The steps of one subject.

    Attributes:
        vertex_map: uint32, (n,), the last frame's output vertex of each input vertex.
    """

    def __init__(
        self, made: EdgeCollapse, positions: Buffer, triangles: Buffer, first: Buffer | None = None
    ) -> None:
        """Add them to those of a frame, after the output is written.

        Args:
            made: whose output moves.
            positions: of the input, float32 (n, 3).
            triangles: of the input, uint32 (m, 3).
            first: uint32 (n,), the vertex of the mesh of `made` of each input vertex, 0xFFFFFFFF where none; None where
                that is the input.
        """
        device, mesh = made.device, made.mesh
        n = mesh.vertex_count
        given, m = positions.shape[0], triangles.shape[0]
        room = min(ROOM * made.target if made.params.targeted else m, m // 2)
        rows = min(n, 3 * room)
        maps, walkers = map_count(device, m)
        self.vertex_map = own = made.allocate("vertex_map", n, np.uint32)
        places = [made.allocate("places", (rows, 4), np.float32) for _ in range(2)]
        known: dict[str, Any] = {
            "parents": made.parents, "numbers": made.numbers, "points": made.points,
            "positions": positions, "triangles": triangles, "survivors": made.survivors,
            "counts": made.counts, "vertices": made.vertices_out,
            "samples": made.allocate("samples", (m, 4), np.float32),
            "ring": made.allocate("ring", 3 * room, np.uint32),
            "owned": made.allocate("owned", (maps, rows + 1), np.uint32),
            "met": made.allocate("met", (maps, rows + 1), np.uint32),
            "sums": made.allocate("sums", (3 * room, 8), np.float32),
            "vertex_count": n, "row_count": rows, "room": room, "triangle_count": m, "map_count": maps,
            "prescale": 1 / made.unscale, "unscale": made.unscale,
            "crease": made.params.crease_cosine,
        }  # fmt: skip

        def add(kernel: str, items: int, **more: Any) -> None:
            made.add(made.fitting(kernel, items, {**known, **more}))

        vertices = chunk_count(device, n)
        add("sort_roots", vertices, places=places[0], vertex_map=own)
        if first is not None:
            self.vertex_map = made.allocate("vertex_map", given, np.uint32)
            more = {"first": first, "second": own, "given_count": given}
            add("sort_chain", chunk_count(device, given), vertex_map=self.vertex_map, **more)
        if walkers != maps:
            made.fill("fit", known["owned"], 0)
            made.fill("fit", known["met"], 0)
        add("sort_count", walkers, vertex_map=self.vertex_map)
        add("sort_starts", 1)
        add("sort_scatter", walkers, vertex_map=self.vertex_map)
        if walkers != maps:
            add("order_rows", vertices)
        chunks = chunk_count(device, 3 * room)
        for step, every in enumerate(EVERY):
            old, new = places[step % 2], places[1 - step % 2]
            add("gather", chunks, places=old, every=every)
            add("move", chunks, places=old, moved=new)
