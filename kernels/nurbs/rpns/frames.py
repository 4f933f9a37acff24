"""What a frame enqueues: KSQuads culled by the view, cut into KSDices by the screen; and room that grows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from lodbench.datasets_gen.nurbs_surface import NurbsModel, NurbsSurface
from lodbench.kernels.nurbs.params import BASES
from lodbench.kernels.nurbs.rpns.params import CULLING, Params
from lodbench.kernels.nurbs.rpns.quads import COLLAPSED, quads_of
from lodbench.kernels.nurbs.tessellated import Tessellated, sampled
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.stages.camera import fit_box, pixel_rows
from lodbench.kernels.stages.compact import Compact
from lodbench.kernels.stages.scan import ExclusiveScan, chunk_local
from lodbench.kernels.subject import POINT, Step
from lodbench.kernels.system import DeviceSurface, Frame

FIRST_VERTICES = 1 << 16  # that there is room for to begin with, where KSQuads adapt
ITEMS = 256  # of a CPU, that share the KSQuads evenly
OCTETS = 2  # of a CPU's group: more would be shared out unevenly
SPARE = 1.25  # times the room that a frame needed
BREAKS = (0.25, 0.5, 0.75)


class Frames(Tessellated):
    """A model under the pipeline, but for what is read of it afterwards.

    Its corners are those of a tessellation with one segment to a KSQuad, the same to the bit on borders that surfaces
    share; borders of KSQuads begin and end there.

    Raises:
        ValueError: more vertices than 32-bit indices can name, or a coordinate that the sums cannot bear.
        Unsupported: the output does not fit the device's memory.
    """

    def __init__(self, device: Device, model: NurbsModel, params: Params) -> None:
        if params.inside_out:
            model = replace(model, surfaces=tuple(map(_turned, model.surfaces)))
        corners = replace(params, level=0, normals=False)
        super().__init__(device, model, corners, sampled(model, corners))
        self._params = self.params = params
        self.defines["NORMALS"] = int(params.normals)
        self.quads = count = model.span_count
        most = params.finest * (2 if params.adapts and params.edges == "tolerant" else 1)
        self._most = np.array([count * (most + 1) ** 2, count * 2 * most**2])
        if self._most.max(initial=0) > 2**32:
            raise ValueError(
                f"level: expected at most 2**32 vertices in all, got {self._most.max():,}"
            )
        self._whole = fit_box(*model.box) if count else None
        corners_of_box = np.array(np.meshgrid(*zip(*model.box, strict=True))).reshape(3, -1).T
        self._ends = np.column_stack([corners_of_box, np.ones(8)])  # of what all lies between
        if not count:
            self.output = (replace(self.output[0], normals=None),)
            self.warm_up()
            return
        self.share()  # of corners
        if params.edges == "tolerant":
            self._steps.clear()
        with self.setup.host("tables"):
            self._tables = quads_of(model, self.grids, self._borders)
        self._items = min(count, ITEMS) if device.is_cpu else count
        self._upload()
        self._add_geometry()
        self._add_sampler()
        self._fixed = len(self._steps)
        room = np.array([FIRST_VERTICES, 2 * FIRST_VERTICES])
        self._make_room(*(np.minimum(self._most, room) if params.adapts else self._most).tolist())
        self.warm_up()
        while self.overflowed():
            self.grow()
            self.warm_up()

    def _upload(self) -> None:
        tables, count = self._tables, self.quads
        with self.setup.host("upload"):
            self._held = {
                name: self.upload(name, getattr(tables, name), role="pattern")
                for name in ("octets", "firsts", "beziers", "choose", "edges", "by_place")
            }
            self._quads = self.upload("quads", tables.rows, role="pattern")
            self._fives = self.upload("fives", tables.fives, role="pattern")
            factors = np.tile(
                np.array([self._params.finest, *BREAKS], np.float32), (len(tables.edges), 1)
            )
            factors[tables.edges[:, 6] == COLLAPSED, 0] = 1
            self._factors = self.upload("factors", factors, role="scratch")
        self._flags = self.allocate("flags", count, np.uint8)
        self._sizes = self.allocate("sizes", (count, 8), np.float32)
        shape = (count if self._params.adapts else 0, 8)
        self._middles = self.allocate("middles", shape, np.float32)
        words = ("kept", "vertex_counts", "triangle_counts", "vertex_offsets", "triangle_offsets")
        self._lists = {name: self.allocate(name, count, np.uint32) for name in words}
        totals = ("total", "vertex_total", "triangle_total")
        self._totals = {name: self.allocate(name, 1, np.uint32) for name in totals}
        self._counts = self.allocate("counts", 2, np.uint32, "output")

    def _add_geometry(self) -> None:
        """Which KSQuads stay."""
        params, read = self._params, self._held
        with self.setup.host("build"):
            switches = {"CULLING": CULLING.index(params.culling)}
            switches["RATIONAL"] = self.defines["RATIONAL"]
            program = self.device.build("nurbs/rpns/geometry.cl", defines=switches)
        none = (0.0, 0.0, 0.0, 0.0)
        self._cull = program.launch(
            "rpns_geometry_cull", len(self._tables.octets), stage="cull", local=OCTETS if self.device.is_cpu else None,
            surfaces=self.buffers["surfaces"], controls=self.buffers["controls"], flags=self._flags,
            eye=none, clip_x=none, clip_y=none, clip_w=none, in_view=1, octet_count=len(self._tables.octets),
            **{name: read[name] for name in ("octets", "firsts", "beziers", "choose")},
        )  # fmt: skip
        self.add(self._cull, bytes=self.buffers["controls"].size_bytes + self.quads)
        with self.holding("scratch"):
            kept = self._lists["kept"]
            compact = Compact(self.device, self._flags, self._totals["total"], indices=kept)
        self.add(compact, stage="compact")

    def _add_sampler(self) -> None:
        """How many KSDices each of them gets."""
        params, count = self._params, self.quads
        switches = {
            "ADAPTIVE": int(params.adapts),
            "TOLERANT": int(params.edges == "tolerant"),
            "UNIFORM": int(params.sampling != "non_uniform"),
            "WATERTIGHT": int(params.edges == "watertight"),
            "DICES": int(params.dice_culling),
            "STREAMING": 0,
            "CHUNK": 8,
            "BASIS": BASES.index(params.basis),
        }
        degrees = [max(s.degree_u, s.degree_v) for s in self.model.surfaces]
        switches["MOST_DEGREE"] = next(d for d in (3, 5, 7) if max(degrees) <= d)
        with self.setup.host("build"):
            self._program = self.device.build(
                "nurbs/rpns/sampler.cl", "nurbs/rpns/dices.cl", defines=self.defines | switches
            )
        read, none = self._held, (0.0, 0.0, 0.0, 0.0)
        shared = {"factors": self._factors, "middles": self._middles}
        self._lengths = None
        if params.adapts:
            octets = len(self._tables.octets)
            self._lengths = self._program.launch(
                "rpns_sampler_lengths", octets, stage="lengths", local=OCTETS if self.device.is_cpu else None,
                octets=read["octets"], edges=read["edges"], firsts=read["firsts"], places=read["by_place"],
                surfaces=self.buffers["surfaces"], controls=self.buffers["controls"], fives=self._fives,
                flags=self._flags, screen_x=none, screen_y=none, screen_w=none,
                side=float(np.sqrt(params.pixel_area)), finest=float(params.finest),
                stride=self._tables.by_place.shape[2], octet_count=octets, **shared,
            )  # fmt: skip
            self.add(self._lengths, bytes=2 * self.buffers["controls"].size_bytes)
        lists, totals = self._lists, self._totals
        launch = self._program.launch(
            "rpns_sampler_sizes", self._items, stage="sizes", local=chunk_local(self.device),
            quads=self._quads, kept=lists["kept"], total=totals["total"], sizes=self._sizes,
            vertex_counts=lists["vertex_counts"], triangle_counts=lists["triangle_counts"],
            quad_count=count, item_count=self._items, **shared,
        )  # fmt: skip
        self.add(launch, bytes=4 * 16 * count)
        self._scan("vertex")

    def _scan(self, what: str) -> None:
        lists, totals = self._lists, self._totals
        with self.holding("scratch"):
            scan = ExclusiveScan(
                self.device, lists[f"{what}_counts"], lists[f"{what}_offsets"], totals[f"{what}_total"],
                live=totals["total"],
            )  # fmt: skip
        self.add(scan, stage="scan")

    def _make_room(self, vertices: int, triangles: int) -> None:
        """The output's buffers and the launches that fill them.

        Raises:
            Unsupported: the device has no room for them.
        """
        params, count, lists, totals = self._params, self.quads, self._lists, self._totals
        shape = (vertices if params.normals else 0, 3)
        self._points = self.allocate("positions", (vertices, 3), np.float32, "output")
        self._directions = self.allocate("normals", shape, np.float32, "output")
        self._triangle = self.allocate("triangles", (triangles, 3), np.uint32, "output")
        self._facing = self.allocate("facing", vertices if params.dice_culling else 0, np.uint8)
        self._room = int(vertices), int(triangles)
        del self._steps[self._fixed :]
        shared = {
            "sizes": self._sizes, "total": totals["total"], "facing": self._facing,
            "vertex_offsets": lists["vertex_offsets"], "quad_count": count, "vertex_room": vertices,
            "item_count": self._items,
        }  # fmt: skip
        read = {name: self.buffers[name] for name in ("surfaces", "spans", "controls", "scales")}
        local = chunk_local(self.device)
        self._evaluate = self._program.launch(
            "rpns_dices_vertices", self._items, stage="dices", local=local, quads=self._quads,
            edges=self._held["edges"], fives=self._fives, factors=self._factors,
            corners=self.positions, kept=lists["kept"], positions=self._points,
            normals=self._directions, triangle_counts=lists["triangle_counts"],
            eye=(0.0, 0.0, 0.0, 0.0), **read, **shared,
        )  # fmt: skip
        size = POINT * (1 + params.normals)
        self.add(self._evaluate, bytes=lambda own: size * own.live()[0])
        self._scan("triangle")
        emit = self._program.launch(
            "rpns_dices_triangles", self._items, stage="emit", local=local,
            triangle_offsets=lists["triangle_offsets"], vertex_total=totals["vertex_total"],
            triangle_total=totals["triangle_total"], triangles=self._triangle,
            counts=self._counts, triangle_room=triangles, **shared,
        )  # fmt: skip
        self.add(emit, lambda own: POINT * own.live()[1])
        self._seen: Any = self  # no view
        self.output = (
            DeviceSurface(
                self._points, self._directions if params.normals else None, self._triangle,
                *self._room, counts=self._counts,
            ),
        )  # fmt: skip

    def steps(self, frame: Frame) -> Sequence[Step]:
        """All steps, as seen by the frame's view; without one nothing is culled, and all is cut as if seen whole."""
        if self.quads and frame.view is not self._seen:
            view = frame.view or self._whole
            assert view is not None
            eye = (*map(float, view.eye), 1.0) if frame.view is not None else (0.0,) * 4
            self._evaluate.set(eye=eye)
            clip = np.asarray(view.world_to_clip, np.float64)
            clip = clip / max(float(np.abs(clip[3]).max()), 1e-37)
            x, y, w = (tuple(map(float, clip[k])) for k in (0, 1, 3))
            ends = self._ends @ clip.T
            inside = (np.abs(ends[:, :2]) <= 0.999 * ends[:, 3:]).all()
            self._cull.set(eye=eye, clip_x=x, clip_y=y, clip_w=w, in_view=int(inside))
            x, y, w = pixel_rows(view)
            if self._lengths is not None:
                self._lengths.set(screen_x=x, screen_y=y, screen_w=w)
            self._seen = frame.view
        return self._steps

    # room

    def needed(self) -> tuple[int, int]:
        """Vertices and triangles of the last frame, whether there was room for them or not."""
        if not self.quads:
            return 0, 0
        wanted = [(self._totals[f"{name}_total"], None) for name in ("vertex", "triangle")]
        vertices, triangles = self.device.read_all(*wanted)
        return int(vertices[0]), int(triangles[0])

    def overflowed(self) -> bool:
        """See `Growing`."""
        if not self.quads or not self._params.adapts:
            return False
        vertices, triangles = self.needed()
        return vertices > self._room[0] or triangles > self._room[1]

    def grow(self) -> None:
        """See `Growing`."""
        room = [
            max(room, min(int(SPARE * needed), int(most)))
            for needed, room, most in zip(self.needed(), self._room, self._most, strict=True)
        ]
        gone = self._points, self._directions, self._triangle
        self.release("output", *gone)
        self.release("scratch", self._facing)
        self.output = ()
        for buffer in (*gone, self._facing):
            buffer.release()
        self._make_room(*room)

    def live_rows(self) -> list[tuple[int, int]]:
        """Vertices and triangles of the last frame."""
        if self.frame is None:
            self.enqueue(Frame(), Timeline())
        return [self.needed()]


def _turned(surface: NurbsSurface) -> NurbsSurface:
    """The same points, u running the other way."""
    knots = surface.knots_u
    return replace(
        surface, knots_u=(knots[0] + knots[-1]) - knots[::-1], points=surface.points[::-1],
        weights=surface.weights[::-1],
    )  # fmt: skip
