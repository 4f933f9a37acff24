"""What chooses a pattern for each coarse triangle: tags, selection and scan, on the device."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.opencl import Buffer, Device
from lodbench.kernels.refine.adaptive_patterns.params import Params
from lodbench.kernels.refine.adaptive_patterns.pool import pool
from lodbench.kernels.refine.adaptive_patterns.reference import edge_depths, pattern_numbers
from lodbench.kernels.refine.adaptive_patterns.tags import KINDS, expected_tags, measures, spans
from lodbench.kernels.refine.surface import Coarse
from lodbench.kernels.refine.surfaces import chosen_surface
from lodbench.kernels.stages.scan import chunk_count, chunk_local
from lodbench.kernels.subject import DeviceSubject
from lodbench.kernels.system import Frame

FOLDER = "refine/adaptive_patterns"
TAG_TOLERANCE = 1e-3  # levels


class Choosing(DeviceSubject):
    """A coarse mesh and a pool; a frame leaves each triangle's pattern and where its vertices and triangles begin.

    ```
    tags          float [n]       depth of each coarse vertex
    patterns      uint  [m]       in the pool, of each coarse triangle
    offsets       uint  [m]       where its vertices begin; starts: where its triangles do
    blends        float [m, 4]    how far the last level of the three edges and of the inside has come
    totals        uint  [2]       vertices and triangles of the frame
    ```

    Attributes:
        pool: all patterns.
    """

    def __init__(
        self, device: Device, mesh: TriangleMesh, params: Params, depths: ArrayLike | None
    ) -> None:
        super().__init__(device)
        given = _given_depths(params, mesh, depths)
        self._params, self._frame = params, Frame()
        self._coarse = Coarse(self, mesh, params, chosen_surface(params))
        self._mesh = self._coarse.mesh
        self.pool = pool(params.finest)
        self._upload(given)
        self._choose()

    def _upload(self, given: NDArray[np.float32] | None) -> None:
        made, count = self.pool, self._coarse.count
        self._spans = spans(self._mesh, self._coarse.diagonal)
        with self.setup.host("upload"):
            self._positions_in = self.upload("coarse", self._mesh.positions, np.float32, (None, 3))
            self._spans_in = self.upload("spans", self._spans, np.float32, (None, 2))
            self._triangles_in = self.upload("corners", self._mesh.triangles, np.uint32, (None, 3))
            self._weights = self.upload("pool", made.weights, np.float32, (2, None), "pattern")
            self._records = self.upload("records", made.records, np.uint32, role="pattern")
            if self._params.indices:
                self._lists = self.upload("lists", made.triangles, np.uint32, role="pattern")
            if self._params.geomorphing:
                self._moves = self.upload("moves", made.moves, np.uint32, role="pattern")
            tags = np.zeros(self._mesh.vertex_count, np.float32) if given is None else given
            self._tags = self.upload("tags", tags, np.float32, (None,), "scratch")
        for name in ("patterns", "offsets", "starts"):
            setattr(self, f"_{name}", self.allocate(name, count, np.uint32))
        self._blends = self.allocate("blends", (count, 4), np.float32)
        self._totals = self.allocate("totals", 2, np.uint32)
        self._counts = self.allocate("counts", 2, np.uint32, "output")

    _patterns: Buffer
    _offsets: Buffer
    _starts: Buffer

    def _choose(self) -> None:
        """What chooses patterns: it does not depend on the room."""
        device, params, count = self.device, self._params, self._coarse.count
        with self.setup.host("build"):
            files = (f"{FOLDER}/tags.cl", f"{FOLDER}/selection.cl")
            program = device.build(*files, defines={"BY": KINDS[params.by]})
        vertex_count = self._mesh.vertex_count
        eye, measure = measures(params, None, self._coarse.diagonal)
        self._tagging = program.launch(
            "adaptive_patterns_tags", vertex_count, stage="tags",
            positions=self._positions_in, spans=self._spans_in, tags=self._tags,
            eye=eye, measure=measure, finest=float(params.finest), vertex_count=vertex_count,
        )  # fmt: skip
        self.add(self._tagging, bytes=24 * vertex_count)
        chunks = chunk_count(device, count)
        sums = self.allocate("chunk_sums", (chunks, 2), np.uint32)
        shared: dict[str, Any] = {
            "offsets": self._offsets, "starts": self._starts, "chunk_sums": sums,
            "totals": self._totals, "triangle_count": count, "chunk_count": chunks,
        }  # fmt: skip
        local = chunk_local(device)
        selecting = program.launch(
            "adaptive_patterns_selection", chunks, stage="selection", local=local,
            triangles=self._triangles_in, tags=self._tags, records=self._records,
            patterns=self._patterns, blends=self._blends, finest=params.finest, **shared,
        )  # fmt: skip
        self.add(selecting, bytes=(12 + 12 + 16) * count)
        if chunks > 1:
            name = "adaptive_patterns_selection_join"
            joining = program.launch(name, chunks, stage="selection", local=local, **shared)
            self.add(joining, bytes=16 * count)

    def needed(self) -> tuple[int, int]:
        """Vertices and triangles of the last frame, whether there was room for them or not."""
        if not self._coarse.count:
            return 0, 0
        vertices, faces = map(int, self.device.read(self._totals))
        return vertices, faces

    def tags(self) -> NDArray[np.float32]:
        """The last frame's depth tags, (n,)."""
        return self.device.read(self._tags)

    def chosen(self) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
        """The pattern of each coarse triangle, and where its vertices begin, (m,) each."""
        return self.device.read(self._patterns), self.device.read(self._offsets)

    def wrong_patterns(self) -> int:
        """Coarse triangles of the last frame with another pattern than numpy gives them; all of them by wrong tags."""
        params, tags = self._params, self.tags()
        if params.by != "given" and len(tags):
            expected = expected_tags(
                params, self._mesh.positions, self._spans, self._frame.view, self._coarse.diagonal
            )
            if not np.abs(tags - expected).max() <= TAG_TOLERANCE:
                return self._coarse.count
        depths, _ = edge_depths(self._mesh.triangles, tags, params.finest)
        return int((pattern_numbers(depths, params.finest) != self.chosen()[0]).sum())


def _given_depths(
    params: Params, mesh: TriangleMesh, depths: ArrayLike | None
) -> NDArray[np.float32] | None:
    if (params.by == "given") != (depths is not None):
        got = "none" if depths is None else f"some with by={params.by!r}"
        raise ValueError(f"depths: expected one per vertex with by='given', got {got}")
    if depths is None:
        return None
    values = np.asarray(depths)
    if values.dtype.kind not in "iuf":
        raise TypeError(f"depths: expected numbers, got {values.dtype}")
    if values.shape != (mesh.vertex_count,) or not np.isfinite(values).all():
        raise ValueError(
            f"depths: expected finite ({mesh.vertex_count},), got shape {values.shape}"
        )
    return values.astype(np.float32)
