"""A last step after the collapses: vertices move to where they fit the input best.

What is left is judged by its distance from the input, of which collapses know only the planes of the mesh as it was.
So points half-way from the centroids of the input's triangles to their corners are samples, each goes to the nearest
triangle at the vertex that its corner went to, and each vertex is solved for the heights of the samples of its
triangles above these, in 3-D. Its neighbours move at the same time: each gets its share of a sample, so that the sum
of squares does not rise (Jensen's inequality). Border vertices, creases and locked vertices stay, and in each step no
vertex moves so far in the plane of a triangle that this could turn over. Triangles stay what they are, and so do
collapses: the fit is no part of their sequence.

Source: ours; distances from planes as in Chen & Medioni 1992, as the mesh optimisation of Hoppe et al. 1993 fits
positions to points.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lodbench.kernels.opencl import Buffer
from lodbench.kernels.stages.scan import chunk_count, map_count

if TYPE_CHECKING:
    from lodbench.kernels.cluster.edge_collapse.host import EdgeCollapse

FILES = tuple(
    f"cluster/edge_collapse/{name}.cl"
    for name in ("fit_sort", "fit_order", "fit_gather", "fit_move")
)
ROOM = 2  # times the target: where more triangles are left, or half of all, vertices stay
SAMPLES, FEW, MANY = 90, 5, 524_288  # see fit_sort.cl
DEFINES = {"FIT_SAMPLES": SAMPLES, "FIT_FEW": FEW, "FIT_MANY": MANY}
EVERY = 3, 3, 1  # of so many samples of a vertex one counts, step by step


@dataclass(frozen=True, eq=False)
class Input:
    """What vertices are fitted to, on the device.

    Attributes:
        positions: float32, (n, 3).
        triangles: uint32, (m, 3).
        vertex_map: uint32, (n,), the vertex of each one in the mesh that is collapsed, 0xFFFFFFFF where none; None:
            that is this one.
    """

    positions: Buffer
    triangles: Buffer
    vertex_map: Buffer | None = None


class Fit:
    """The steps of one subject.

    Attributes:
        vertex_map: uint32, the last frame's output vertex of each vertex of the mesh that is collapsed.
        whole_map: the same of each vertex of the input that it is fitted to.
    """

    def __init__(self, made: EdgeCollapse, to: Input) -> None:
        """Add them to those of a frame, after the output is written."""
        device, mesh = made.device, made.mesh
        n = mesh.vertex_count
        given, m = to.positions.shape[0], to.triangles.shape[0]
        room = min(ROOM * made.target if made.params.targeted else m, m // 2)
        rows = min(n, 3 * room)
        samples = min(3 * m, 2 * min(SAMPLES * room, max(FEW * room, MANY)))
        maps, walkers = map_count(device, m)
        self.vertex_map = self.whole_map = made.allocate("vertex_map", n, np.uint32)
        places = [made.allocate("places", (rows, 4), np.float32) for _ in range(2)]
        known: dict[str, Any] = {
            "parents": made.parents, "numbers": made.numbers, "points": made.points,
            "positions": to.positions, "triangles": to.triangles, "survivors": made.survivors,
            "counts": made.counts, "vertices": made.vertices_out,
            "samples": made.allocate("samples", (samples, 4), np.float32),
            "ring": made.allocate("ring", 9 * room, np.uint32),
            "slots": made.allocate("slots", 3 * room, np.uint32),
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
        add("sort_roots", vertices, places=places[0], vertex_map=self.vertex_map)
        if to.vertex_map is not None:
            self.whole_map = made.allocate("whole_map", given, np.uint32)
            add(
                "sort_chain", chunk_count(device, given), first=to.vertex_map,
                second=self.vertex_map, vertex_map=self.whole_map, given_count=given,
            )  # fmt: skip
        if walkers != maps:
            made.fill("fit", known["owned"], 0)
            made.fill("fit", known["met"], 0)
        add("sort_count", walkers, vertex_map=self.whole_map)
        add("sort_starts", 1)
        add("sort_scatter", walkers, vertex_map=self.whole_map)
        if walkers != maps:
            add("order_rows", vertices)
        chunks = chunk_count(device, rows)
        for step, every in enumerate(EVERY):
            old, new = places[step % 2], places[1 - step % 2]
            add("gather", chunks, places=old, every=every)
            add("move", chunks, places=old, moved=new)
