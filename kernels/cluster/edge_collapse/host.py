"""Edge collapse on the device: the mesh as it shrinks, sweep by sweep.

Long because all arguments of the kernels are set here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.edge_collapse.bound import Limit
from lodbench.kernels.cluster.edge_collapse.curve import first_of, hilberts
from lodbench.kernels.cluster.edge_collapse.fit import DEFINES as FIT_DEFINES
from lodbench.kernels.cluster.edge_collapse.fit import FILES as FIT_FILES
from lodbench.kernels.cluster.edge_collapse.fit import Fit, Input
from lodbench.kernels.cluster.edge_collapse.params import Params
from lodbench.kernels.cluster.edge_collapse.sweeps import (
    APART,
    ASKED,
    ASKED_LAST,
    CAPACITY,
    Sweep,
    bits_of,
    slice_words,
    sweeps,
)
from lodbench.kernels.cluster.edge_collapse.verdict import verdict
from lodbench.kernels.cluster.mapped import Mapped
from lodbench.kernels.cluster.upload import Upload
from lodbench.kernels.opencl import Buffer, Launch, Timeline
from lodbench.kernels.stages.scan import chunk_count, chunk_local, map_count
from lodbench.kernels.subject import POINT, WORD
from lodbench.kernels.system import Check, DeviceSurface, Frame
from lodbench.kernels.targets import missed

FILES = (
    tuple(
        f"cluster/edge_collapse/{name}.cl"
        for name in ("setup", "sort", "plan", "geometry", "vertex", "emit")
    )
    + FIT_FILES
)
BINS = 512  # of costs, see state.cl
STATE = 16  # words
BLOCKS_BEFORE, EACH_BEFORE, DONE = 3, 4, 5
SWEEPS, COLLAPSES = 10, 11
PLANNED = 6  # last sweeps that are enqueued before it is asked whether more are needed


class EdgeCollapse(Mapped):
    """One mesh, shrunk to a number of triangles.

    ```
    points      float [4 * vertices]    x y z brought near 1, triangles at the vertex
    rows        uint  [4 * triangles]   a b c, row of the input; each block's at the front of its room
    sorted      uint  [4 * triangles]   the same without gaps, along the curve
    parents     uint  [vertices]        where a vertex went
    histograms  uint  [BINS * blocks]   edges by cost
    scratch     uint  [slice * items]   a block as the work-item sees it
    survivors   uint  [3 * triangles]   output triangles
    sources     uint  [triangles]       their rows in the input
    sequence    uint  [4 * vertices]    where recorded: by what the vertices that went are ordered
    limits      float [vertices]        where there is a bound: what collapses may cost
    moves       float [4 * vertices]    where recorded: to where their others moved, triangles that went
    counts      uint  [2]               live output vertices and triangles
    ```

    Attributes:
        target: triangles that may be left.
        mesh: what is simplified.
        fit: the last step, if there is one.
        files, defines: what its kernels are built of.
    """

    files = FILES
    defines: Mapping[str, int] = {"BLOCK": CAPACITY, **FIT_DEFINES}

    def __init__(
        self,
        upload: Upload,
        params: Params,
        target: int,
        locked: NDArray[np.bool_] | None = None,
        recorded: bool = False,
        limit: Limit | None = None,
        held: NDArray[np.float64] | None = None,
        to: Input | None = None,
    ) -> None:
        super().__init__(upload.device, upload.setup)
        self.mesh, self.params, self.target = upload.mesh, params, target
        self._limit, self._held = limit, held
        self.hold("input", upload.positions, upload.triangles)
        self._program = upload.program
        self._vertices, self._triangles = upload.mesh.vertex_count, upload.mesh.triangle_count
        rows = upload.mesh.vertex_count if recorded else 1
        self.sequence = self.allocate("sequence", (rows, 4), np.uint32)
        self.moves = self.allocate("moves", (rows, 4), np.float32)
        self._recorded = recorded
        # first steps of the sweeps after those planned, and of what comes after all
        self._later: list[int] = []
        self._setup(upload, locked)
        self._sweeps(upload)
        self._emit(upload)
        self.fit: Fit | None = None
        if params.fits(target):
            to = to or Input(upload.positions, upload.triangles)
            self.fit = Fit(self, to)  # pyright: ignore[reportArgumentType]
        surface = DeviceSurface(
            positions=self.vertices_out, normals=None, triangles=self.survivors,
            vertex_count=self._vertices, triangle_count=self._triangles, counts=self.counts,
        )  # fmt: skip
        self.output = (surface,)

    def _launch(self, kernel: str, count: int, /, **arguments: Any) -> Launch:
        stage = kernel.split("_")[0]
        return self._program.launch(
            f"edge_collapse_{kernel}", count, stage=stage, local=chunk_local(self.device), **arguments
        )  # fmt: skip

    def _chunked(self, kernel: str, count: int, /, **arguments: Any) -> Launch:
        """A launch of one item per chunk of `count` rows."""
        chunks = chunk_count(self.device, count)
        return self._launch(kernel, chunks, chunk_count=chunks, **arguments)

    def fitting(self, kernel: str, items: int, known: Mapping[str, Any]) -> Launch:
        """A launch of `fit.py`, of one item per chunk, with those arguments that the kernel has."""
        name, known = f"edge_collapse_fit_{kernel}", {**known, "chunk_count": items}
        wanted = [parameter.name for parameter in self._program.kernels[name]]
        return self._launch(f"fit_{kernel}", items, **{name: known[name] for name in wanted})

    def _setup(self, upload: Upload, locked: NDArray[np.bool_] | None) -> None:
        """The working copies, made anew in every frame."""
        n, m, block = self._vertices, self._triangles, self.params.block
        blocks = max(-(-m // block), 1)
        extent = float((upload.high - upload.low).max())
        exponent = -math.frexp(extent)[1] if extent > 0 else 0
        self._prescale = math.ldexp(1.0, max(-126, min(126, exponent)))
        self.points = self.allocate("points", (n, 4), np.float32)
        self.loss = self.allocate("loss", n, np.uint32)
        self.parents = self.allocate("parents", n, np.uint32)
        self._limits(n)
        self._penalties(n)
        self.rows = self.allocate("rows", (m, 4), np.uint32)
        self.block_live = self.allocate("block_live", blocks, np.uint32)
        self.state = self.allocate("state", STATE, np.uint32)
        first = np.zeros(STATE, np.uint32)
        first[[BLOCKS_BEFORE, EACH_BEFORE]] = -(-m // block), block
        begin = self.upload("begin", first, role="scratch")
        locks = np.zeros(1, np.uint32) if locked is None else locked.astype(np.uint32)
        device, state = self.device, self.state
        self.add(lambda timeline: device.copy(timeline, "setup", begin, state), stage="setup")
        maps, walkers = map_count(device, m)
        degrees = self.allocate("degrees", (maps, n), np.uint32)
        counted = {"degrees": degrees, "vertex_count": n, "map_count": maps}
        self.fill("setup", degrees, 0)
        self.add(
            self._launch(
                "setup_rows", walkers, triangles=upload.triangles, rows=self.rows,
                block_live=self.block_live, block=block, triangle_count=m, chunk_count=walkers, **counted,
            ),
            bytes=(POINT + 4 * WORD) * m,
        )  # fmt: skip
        self.add(
            self._chunked(
                "setup_points", n, positions=upload.positions,
                locked=self.upload("locked", locks), locks=int(locked is not None),
                points=self.points, loss=self.loss, parents=self.parents,
                prescale=self._prescale, **counted,
            ),
            bytes=(POINT + 6 * WORD) * n,
        )  # fmt: skip
        self._fold = self._chunked(
            "vertex_fold", n, points=self.points, loss=self.loss, state=self.state,
            block_live=self.block_live, target=self.target, vertex_count=n,
        )  # fmt: skip

    def _limits(self, n: int) -> None:
        """What collapses may cost at each vertex, in units of `points`, if that is limited."""
        self.limits = self.allocate("limits", 1 if self._limit is None else n, np.float32)
        if self._limit is None:
            return
        unit = self.mesh.diagonal * self._prescale
        given = self.upload("given_limits", (self._limit.distances * unit).astype(np.float32))
        device, limits = self.device, self.limits
        self.add(lambda timeline: device.copy(timeline, "setup", given, limits), stage="setup")

    def _penalties(self, n: int) -> None:
        """What attributes add to the quadrics, in units of `points`, if they do."""
        self.held = self.allocate("held", (1 if self._held is None else n, 8), np.float32)
        if self._held is None:
            return
        planes = np.zeros((n, 8), np.float32)
        planes[:, :6] = self._held * self._prescale**2
        given, device, held = self.upload("given_planes", planes), self.device, self.held
        self.add(lambda timeline: device.copy(timeline, "setup", given, held), stage="setup")

    def _sweeps(self, upload: Upload) -> None:
        """As many as may be needed; those after the target is met do nothing."""
        params, m, block = self.params, self._triangles, self.params.block
        blocks = max(-(-m // block), 1)
        extent = float((upload.high - upload.low).max()) * self._prescale
        low, bits = upload.low * self._prescale, bits_of(m, block)
        chunks = chunk_count(self.device, m)
        orders = self.upload("orders", hilberts(bits), role="scratch", lent=True)
        planned = list(sweeps(params, m, self.target, self._limit))
        schedule = self.upload(
            "schedule", self._schedule(planned, extent, blocks), role="scratch", lent=True
        )
        keys = self.allocate("keys", m, np.uint32)
        offsets = self.allocate("offsets", (chunks, 8**bits), np.uint32)
        sorted_ = self.allocate("sorted", (m, 4), np.uint32)
        histograms = self.allocate("histograms", (blocks, BINS), np.uint32)
        totals = self.allocate("totals", BINS, np.uint32)
        quotas = self.allocate("quotas", blocks, np.uint32)
        items = min(blocks, 4 * self.device.facts.compute_units)
        scratch = self.allocate("scratch", (items, slice_words()), np.uint32)
        shared = {"rows": self.rows, "block_live": self.block_live, "state": self.state}
        sort = {**shared, "schedule": schedule, "keys": keys, "offsets": offsets}
        within = {
            "points": self.points, "sorted": sorted_, "state": self.state, "scratch": scratch,
            "border_weight": params.border_weight, "keep_border": int(params.preserve_border),
            "crease": params.crease_cosine, "takers": items, "held": self.held,
            "holding": int(self._held is not None),
        }  # fmt: skip
        collapse = self._launch(
            "geometry_collapse", items, quotas=quotas, loss=self.loss, parents=self.parents,
            rows=self.rows, block_live=self.block_live, schedule=schedule, limits=self.limits,
            limited=int(self._limit is not None), sequence=self.sequence, moves=self.moves,
            recorded=int(self._recorded), **within,
        )  # fmt: skip
        launches = (
            self._chunked(
                "sort_keys", m, points=self.points, orders=orders, low=(*low, 0), **sort
            ),
            self._launch(
                "sort_scan", 1, schedule=schedule, offsets=offsets, state=self.state,
                chunk_count=chunks,
            ),
            self._chunked("sort_scatter", m, sorted=sorted_, **sort),
            self._launch("geometry_sample", items, histograms=histograms, **within),
            self._launch(
                "plan_quotas", 1, histograms=histograms, schedule=schedule, quotas=quotas,
                totals=totals, state=self.state, target=self.target,
            ),
            collapse,
            self._fold,
        )  # fmt: skip
        # what stays of each share depends on the mesh: the least that a sweep must read and write is left out
        for sweep in planned:
            if sweep.number > params.sweeps + PLANNED:
                self._later.append(len(self._steps))
            for launch in launches:
                self.add(launch)
        self._later.append(len(self._steps))

    def _schedule(self, planned: Sequence[Sweep], extent: float, blocks: int) -> NDArray[np.uint32]:
        """What the kernels are told of each sweep, (sweeps, 16): words as `state.cl` has them."""
        words = np.zeros((len(planned), 16), np.uint32)
        numbers = words.view(np.float32)
        cosine = math.cos(math.radians(self.params.normal_limit))
        for row, number, sweep in zip(words, numbers, planned, strict=True):
            asked, apart = (ASKED_LAST, APART) if sweep.last else (ASKED, blocks)
            row[:7] = (
                sweep.bits, first_of(sweep.bits), sweep.block, sweep.whole, asked, apart, sweep.goal
            )  # fmt: skip
            turn = 0.0 if sweep.stubborn else cosine * cosine
            cells = sweep.along / extent if extent > 0 else 0.0
            number[7:14] = sweep.gain, sweep.least, turn, cells, *sweep.shift
        return words

    def enqueue(self, frame: Frame, timeline: Timeline) -> None:
        """Enqueue the frame's steps; it waits for one word before sweeps that few meshes need: is the target met?"""
        self.frame, self._rows, self._enqueued = frame, None, []
        bounds = [0, *self._later, len(self._steps)]
        for first, past in pairwise(bounds):
            if first in self._later[:-1] and bool(self.device.read(self.state)[DONE]):
                continue
            for step in self._steps[first:past]:
                step.enqueue(timeline)
            self._enqueued += self._steps[first:past]

    def _emit(self, upload: Upload) -> None:
        n, m = self._vertices, self._triangles
        self.numbers = self.allocate("numbers", n, np.uint32)
        self.vertices_out = self.allocate("vertices", (n, 3), np.float32, "output")
        self.survivors = self.allocate("survivors", (m, 3), np.uint32, "output")
        self._sources = self.allocate("sources", m, np.uint32, "output")
        self.counts = self.allocate("counts", 2, np.uint32, "output")
        sums = self.allocate("chunk_sums", chunk_count(self.device, n), np.uint32)
        given = {"points": self.points, "chunk_sums": sums, "vertex_count": n}
        self.add(self._chunked("emit_count", n, **given), bytes=4 * WORD * n)
        self.add(
            self._chunked(
                "emit_vertices", n, numbers=self.numbers, vertices=self.vertices_out,
                counts=self.counts, unscale=self.unscale, **given,
            ),
            bytes=5 * WORD * n,
        )  # fmt: skip
        self.add(
            self._chunked(
                "emit_triangles", m, rows=self.rows, block_live=self.block_live,
                numbers=self.numbers, state=self.state, survivors=self.survivors,
                sources=self._sources, counts=self.counts,
            ),
            bytes=lambda own: 2 * POINT * own.live()[1],
        )  # fmt: skip

    def vertex_map(self) -> NDArray[np.uint32]:
        """The last frame's, which the fit has too."""
        if self.fit is None or self._map_out is not None:
            return super().vertex_map()
        self.live()
        return self.device.read(self.fit.vertex_map)

    def map_vertices(self) -> None:
        """See `Mapped`; the fit fills it anyway."""
        if self.fit is None:
            super().map_vertices()
        else:
            self._map_out = self.fit.vertex_map

    def mapping(self) -> tuple[Launch, Buffer]:
        """What writes `vertex_map`, and where to."""
        result = self.device.allocate("vertex_map", self._vertices, np.uint32)
        launch = self._chunked(
            "emit_map", self._vertices, parents=self.parents, numbers=self.numbers,
            vertex_map=result, vertex_count=self._vertices,
        )  # fmt: skip
        return launch, result

    def read_counts(self, counts: Sequence[Buffer]) -> Sequence[NDArray[np.uint32]]:
        """As every subject's; the same wait tells what the sweeps did."""
        *found, self._told = super().read_counts([*counts, self.state])
        return found

    def result(self) -> Sequence[TriangleMesh]:
        """The last frame's mesh, read back."""
        vertices, triangles = self.live()
        wanted = (self.vertices_out, vertices), (self.survivors, triangles)
        return [TriangleMesh.of_kernels(*self.device.read_all(*wanted))]

    def sources(self) -> NDArray[np.uint32]:
        """The input triangle of each output triangle of the last frame, corner by corner."""
        return self.device.read(self._sources, self.live()[1])

    @property
    def unscale(self) -> float:
        """Model units per unit of `points` and `moves`, a power of two."""
        return 1 / self._prescale

    def more_counters(self) -> Mapping[str, int | float]:
        """Sizes in, sweeps and collapses done, and how near the target is."""
        self.live()
        state = self._told
        return {
            "vertices_in": self._vertices, "triangles_in": self._triangles,
            "sweeps": int(state[SWEEPS]), "collapses": int(state[COLLAPSES]),
            **(missed(self.target, self.live()[1]) if self.params.targeted else {}),
            **({} if self._limit is None else {"tries": self._limit.tries}),
        }  # fmt: skip

    def check(self) -> Check:
        """See `verdict`."""
        return verdict(self)  # pyright: ignore[reportArgumentType]
