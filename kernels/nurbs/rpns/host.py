"""A model's grids and the KSQuads of each frame: culled by the view, then triangles of what stays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.nurbs_surface import NurbsModel
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.launching import group_size
from lodbench.kernels.nurbs.rpns.params import CULLING, Params
from lodbench.kernels.nurbs.rpns.quads import quads_of
from lodbench.kernels.nurbs.rpns.reference import visible
from lodbench.kernels.nurbs.tessellated import Tessellated, sampled
from lodbench.kernels.opencl import Device
from lodbench.kernels.stages.compact import Compact
from lodbench.kernels.subject import POINT, Step
from lodbench.kernels.system import Check, DeviceSurface, Frame


class Rpns(Tessellated):
    """A model under the pipeline: see `lodbench.kernels.nurbs.rpns`."""

    def __init__(self, device: Device, model: NurbsModel, params: Params) -> None:
        super().__init__(device, model, params, sampled(model, params))
        self.quads = count = model.span_count
        segments = 1 << params.level
        with self.setup.host("tables"):
            tables = quads_of(model, self.grids, segments)
        self._seen: NDArray[np.float64] | None = None
        if count:
            self._add_geometry(tables, segments, params)
        self.finish()

    def _add_geometry(self, tables, segments: int, params: Params) -> None:
        device, count = self.device, self.quads
        with self.setup.host("upload"):
            read = {
                name: self.upload(name, getattr(tables, name), role="pattern")
                for name in ("octets", "firsts", "beziers", "choose")
            }
            places = self.upload("quad_places", tables.places, role="pattern")
        self._flags = self.allocate("flags", count, np.uint8)
        kept, total = self.allocate("kept", count, np.uint32), self.allocate("total", 1, np.uint32)
        counts = self.allocate("counts", 2, np.uint32, "output")
        (whole,) = self.output
        triangles = whole.triangles
        self.output = (
            DeviceSurface(
                self.positions, whole.normals, triangles, self.vertices, whole.triangle_count,
                counts=counts,
            ),
        )  # fmt: skip
        with self.setup.host("build"):
            program = device.build(
                "nurbs/rpns/geometry.cl", defines={"CULLING": CULLING.index(params.culling)}
            )
        self._cull = program.launch(
            "rpns_geometry_cull", len(tables.octets), stage="cull", local=group_size(device),
            surfaces=self.buffers["surfaces"], controls=self.buffers["controls"], flags=self._flags,
            eye=(0.0, 0.0, 0.0, 0.0), octet_count=len(tables.octets), **read,
        )  # fmt: skip
        self.add(self._cull, bytes=self.buffers["controls"].size_bytes + count)
        with self.holding("scratch"):
            compact = Compact(device, self._flags, total, indices=kept, stage="compact")
        self.add(compact, stage="compact")
        emit = program.launch(
            "rpns_geometry_emit", count, stage="emit", kept=kept, total=total, places=places,
            triangles=triangles, counts=counts, segments=segments, vertex_count=self.vertices,
            quad_count=count,
        )  # fmt: skip
        self.add(emit, lambda own: POINT * own.live()[1])

    def steps(self, frame: Frame) -> Sequence[Step]:
        """All steps, culled as seen from the frame's eye; without a view nothing is."""
        if self.quads:
            eye = None if frame.view is None else frame.view.eye
            self._cull.set(eye=(0.0, 0.0, 0.0, 0.0) if eye is None else (*map(float, eye), 1.0))
        return self._steps

    def kept(self) -> NDArray[np.bool_]:
        """Which KSQuads the last frame kept, in their order."""
        self.live()
        if not self.quads:
            return np.zeros(0, bool)
        return self.device.read(self._flags).astype(bool)

    def result(self) -> Sequence[TriangleMesh]:
        """The last frame's mesh: all vertices, and the triangles of the KSQuads that stayed."""
        positions, normals = self._read()
        if not self.quads:
            return [TriangleMesh(positions, np.zeros((0, 3), np.uint32), normals)]
        count = self.live()[1]
        triangles = self.device.read(self.output[0].triangles, count)
        return [TriangleMesh(positions, triangles, normals)]

    def check(self) -> Check:
        """Points and normals as of every tessellation; certified culling must have dropped nothing that is visible."""
        found = super().check()
        certified = getattr(self._params, "culling", "") == "certified"
        if found.passed and certified and (wrong := self.lost()[1]):
            what = "KSQuads culled of which a sample faces the eye"
            return Check(False, what, float(wrong), 0.0)
        return found

    def lost(self) -> tuple[int, int]:
        """KSQuads that the last frame culled, and those of them of which some sample faces the eye."""
        kept = self.kept()
        view = None if self.frame is None else self.frame.view
        if view is None or kept.all():
            return int((~kept).sum()), 0
        seen = visible(self.model, view.eye)
        return int((~kept).sum()), int((seen[~kept] > 0).sum())

    def more_counters(self) -> Mapping[str, int | float]:
        """With the KSQuads kept and culled, and those culled of which a sample faces the eye."""
        culled, wrong = self.lost()
        return {
            **super().more_counters(),
            "quads_kept": self.quads - culled,
            "quads_culled": culled,
            "quads_lost": wrong,
        }
