"""Edge collapse in rounds of independent collapses: the form for devices of many small cores."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from lodbench.kernels.cluster.edge_collapse.fit import DEFINES as FIT_DEFINES
from lodbench.kernels.cluster.edge_collapse.fit import FILES as FIT_FILES
from lodbench.kernels.cluster.edge_collapse.host import BINS, EdgeCollapse
from lodbench.kernels.cluster.upload import Upload
from lodbench.kernels.opencl import Buffer, Launch, Timeline
from lodbench.kernels.stages.scan import chunk_count, chunk_local
from lodbench.kernels.system import Frame

FILES = tuple(
    f"cluster/edge_collapse/{name}.cl"
    for name in (
        "setup", "vertex", "rounds_ends", "rounds_vertex", "rounds_geometry", "rounds_select",
        "rounds_apply", "rounds_compact", "emit",
    )
) + FIT_FILES  # fmt: skip
PASSES = 3  # selections from the costs of one round, as in rounds_state.cl
SHARE = 0.1  # of the edges that may go in a round
RATE = 0.1  # of the triangles that go in one, about
MORE = 4  # rounds between two looks at whether the target is met
MOST = 2000  # rounds, whatever comes
DONE, MET = 5, 8  # words of the state


class Rounds(EdgeCollapse):
    """One mesh, shrunk to a number of triangles; in the place of rows, blocks and slices it has rings of vertices.

    Of what a round leaves there are two, the generation before and the one that is made of it:

    ```
    places      float [4 * vertices]       x y z, not 0: it stays
    ids         uint  [vertices]           the vertex of the mesh
    starts      uint  [vertices + 1]       of the rings
    ring        uint  [2 * corners]        next, previous vertex of each triangle at a vertex
    costs       float [corners + 8]        of the edge to the next one
    rim_costs   float [vertices]           of the edge that comes over the border
    ```

    Attributes:
        most_rounds: of a frame, for tests.
    """

    files = FILES
    defines: Mapping[str, int] = {"MANY": 64, **FIT_DEFINES}
    most_rounds = MOST

    def _sweeps(self, upload: Upload) -> None:
        """Rounds are enqueued while a frame runs: how many there will be the mesh tells."""
        n, m = self._vertices, self._triangles
        self._chunks = chunk_count(self.device, n)
        make = self.allocate
        self._made: list[dict[str, Buffer]] = [
            {
                "places": make("places", (n, 4), np.float32),
                "ids": make("ids", n, np.uint32),
                "starts": make("starts", n + 1, np.uint32),
                "ring": make("ring", (3 * m, 2), np.uint32),
                "costs": make("costs", 3 * m + 8, np.float32),
                "rim_costs": make("rim_costs", n, np.float32),
            }
            for _ in range(2)
        ]
        self._shared: dict[str, Buffer] = {
            "planes": make("planes", (n, 8), np.float32),
            "kinds": make("kinds", n, np.uint8),
            "rims": make("rims", n, np.uint32),
            "degrees": make("degrees", n, np.uint32),
            "absorbed": make("absorbed", n, np.uint32),
            "touched": make("touched", n, np.uint8),
            "best": make("best", (n, 2), np.uint32),
            "winners": make("winners", (n, 4), np.uint32),
            "spots": make("spots", (n, 4), np.float32),
            "winner_count": make("winner_count", self._chunks, np.uint32),
            "chunk_sums": make("chunk_sums", (self._chunks, 2), np.uint32),
            "numbers": make("numbers", n, np.uint32),
            "cursors": make("cursors", n, np.uint32),
            "histograms": make("histograms", (self._chunks, BINS), np.uint32),
            "totals": make("totals", BINS, np.uint32),
            "cuts": make("cuts", (PASSES, BINS), np.uint32),
            "points": self.points, "rows": self.rows, "parents": self.parents, "state": self.state,
            "block_live": self.block_live, "sequence": self.sequence, "moves": self.moves,
            "limits": self.limits, "held": self.held,
        }  # fmt: skip
        self._more = {
            "limited": int(self._limit is not None),
            "holding": int(self._held is not None),
        }
        self.fill("setup", self._shared["totals"], 0)
        self.add(self._round("ends_begin", 0, vertex_count=n))
        self.add(self._round("compact_sum", 0, target=self.target))
        self.add(self._round("compact_number", 0))
        rows = chunk_count(self.device, m)
        self.add(self._round("ends_scatter", 0, triangle_count=m, chunk_count=rows))
        self.add(self._round("ends_order", 1))
        self._before = len(self._steps)
        self._rounds = [self._one(1), self._one(0)]
        roots = {"roots": self._shared["numbers"]}
        self.add(self._round("ends_roots", 0, vertex_count=n, **roots))
        block = {"block": self.params.block, "triangle_count": m, "chunk_count": rows}
        self.add(self._round("ends_rows", 0, **block, **roots))

    def _one(self, generation: int) -> list[Launch]:
        """A round that makes the other generation of this one."""
        params = self.params
        cosine = math.cos(math.radians(params.normal_limit))
        held = {
            "border_weight": params.border_weight, "keep_border": int(params.preserve_border),
            "crease": params.crease_cosine,
        }  # fmt: skip
        launches = [
            self._round("vertex_quadrics", generation, **held),
            self._round("geometry_costs", generation),
            self._round("geometry_plan", generation, least=SHARE, patient=self._more["limited"]),
        ]
        aim = {"target": self.target}
        for number in range(PASSES):
            turn = {"pass": number}
            launches += [
                self._round("geometry_best", generation, **turn),
                self._round("select_edges", generation, turn_limit=cosine * cosine, **turn, **aim),
                self._round(
                    "apply_winners", generation, recorded=int(self._recorded), **turn, **aim
                ),
            ]
        return [
            *launches,
            self._round("compact_sum", generation, target=self.target),
            self._round("compact_number", generation),
            self._round("compact_rings", generation),
        ]

    def _round(self, kernel: str, generation: int, **arguments: Any) -> Launch:
        """A launch of one item per chunk of vertices, or of one, with the buffers that its source names."""
        old, new = self._made[generation], self._made[1 - generation]
        known: dict[str, Any] = {
            **self._shared, **old, **{f"new_{name}": buffer for name, buffer in new.items()},
            "generation": generation, "chunk_count": self._chunks, **self._more, **arguments,
        }  # fmt: skip
        name = f"edge_collapse_rounds_{kernel}"
        wanted = [parameter.name for parameter in self._program.kernels[name]]
        items = known["chunk_count"] if "chunk_count" in wanted else 1
        return self._program.launch(
            name, items, stage=kernel.split("_")[0], local=chunk_local(self.device),
            **{name: known[name] for name in wanted},
        )  # fmt: skip

    def enqueue(self, frame: Frame, timeline: Timeline) -> None:
        """Enqueue the frame's steps. It waits now and then, to read one word: whether the target is met."""
        self._enqueued = self.steps(frame)
        self.frame, self._rows = frame, None
        for step in self._enqueued[: self._before]:
            step.enqueue(timeline)
        aim = self.target if self._limit is None else max(self._limit.guess, self.target)
        share = max(aim, 1) / max(self._triangles, 1)
        planned = max(int(math.log(share) / math.log(1 - RATE)), MORE)
        done, rounds = False, 0
        while not done and rounds < self.most_rounds:
            for _ in range(min(planned, self.most_rounds - rounds)):
                for launch in self._rounds[rounds % 2]:
                    launch(timeline)
                rounds += 1
            planned = MORE
            done = bool(self.device.read(self.state)[[DONE, MET]].any())
        for step in self._enqueued[self._before :]:
            step.enqueue(timeline)
