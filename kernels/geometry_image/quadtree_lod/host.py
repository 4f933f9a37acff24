"""A geometry image on a device: its quadtree, and the launches that draw it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import GeometryImage, TriangleMesh
from lodbench.kernels.device import Device
from lodbench.kernels.geometry_image import parameterisation
from lodbench.kernels.geometry_image.quadtree_lod import reference
from lodbench.kernels.geometry_image.quadtree_lod.tree import FOLDER, Tree
from lodbench.kernels.geometry_image.quadtree_lod.view import Detail, detail_of
from lodbench.kernels.program import Launch
from lodbench.kernels.stages.scan import ExclusiveScan
from lodbench.kernels.stages.timeline import Timeline
from lodbench.kernels.system import Check, DeviceSurface, Footprint, Frame, Traffic

if TYPE_CHECKING:
    from lodbench.kernels.geometry_image.quadtree_lod import Params

_PREFIX = "quadtree_lod_"
CPU_RUN = 64  # texels or samples of one work-item; a GPU has items enough for one each
CPU_GROUP = 4  # such items in a group: enough groups for all cores


def prepare(device: Device, mesh: TriangleMesh | GeometryImage, params: Params) -> QuadtreeLod:
    """The image and its quadtree on the device, made of a triangle mesh where one is given.

    Raises:
        NotSpherical: the mesh is not one closed surface of genus 0.
        Unsupported: no room.
    """
    setup = Timeline()
    params = params.counted(mesh.triangle_count)
    return QuadtreeLod(device, image_of(device, mesh, params, setup), params, setup)


def image_of(
    device: Device, mesh: TriangleMesh | GeometryImage, params: Params, setup: Timeline
) -> GeometryImage | None:
    """The geometry image given, or made of a mesh; None where the mesh has no triangles. Seconds go to `setup`."""
    if isinstance(mesh, GeometryImage):
        return mesh
    if not mesh.triangle_count:
        return None
    made = parameterisation.make(
        mesh, params.n, params.mode, params.seed, params.turn, device, params.cache
    )
    setup.stage_s |= made.seconds
    setup.from_cache["parameterise"] = made.spherical.from_cache
    return made.image


class QuadtreeLod:
    """One geometry image; `enqueue` leaves the surface that the frame asks for in `output`.

    Without an image there is nothing to draw: no triangles in, no triangles out.
    """

    def __init__(
        self, device: Device, image: GeometryImage | None, params: Params, setup: Timeline
    ) -> None:
        self._device, self._image, self.params, self.setup = device, image, params, setup
        self._frame: list[Callable[[Timeline], Any]] = []
        self.last: Detail | None = None
        if image is None:
            self._allocate_output(1, 1)
            device.fill(Timeline(), "upload", self._counts, 0)
            return
        before = device.used_bytes
        self.tree = Tree(device, image, params.placement, params.measure, setup)
        self._n = self.tree.n
        self._size = self.tree.diagonal * self.tree.scale  # the diagonal in the tree's units
        self.threshold = params.threshold * self._size
        self._allocate_output(4**self._n + 2, 2 * 4**self._n)
        with setup.host("build"):
            self._make_frame()
        held = self.tree.input_bytes + self.tree.tree_bytes + self._output_bytes()
        self._scratch = device.used_bytes - before - held
        with setup.host("first_launch"):
            self._first_frames()
        if params.target_count is not None:
            with setup.host("search"):
                self.threshold = self._search(params.target_count)

    def _allocate_output(self, vertices: int, triangles: int) -> None:
        device = self._device
        self._out_positions = device.allocate("positions", (vertices, 3), np.float32)
        self._out_normals = device.allocate("normals", (vertices, 3), np.float32)
        self._out_triangles = device.allocate("triangles", (triangles, 3), np.uint32)
        self._counts = device.allocate("counts", 2, np.uint32)

    def _make_frame(self) -> None:
        device, tree = self._device, self.tree
        n, side = tree.n, tree.side
        run = min(CPU_RUN, 1 << n) if device.is_cpu and n >= 4 else 1
        local = min(CPU_GROUP, device.local_size) if run > 1 else None
        programs = [
            device.build(f"{FOLDER}/{name}.cl", defines={"RUN": run})
            for name in ("fragment", "geometry_mark", "geometry", "vertex")
        ]

        def launch(kernel: str, items: int, stage: str, **given: Any) -> Launch:
            program = next(p for p in programs if _PREFIX + kernel in p.kernels)
            return program.launch(
                _PREFIX + kernel, items, stage=stage, local=local, n=n, run_count=items, **given
            )

        samples, node_runs, row_runs = side * side, tree.texels // run, side * ((1 << n) // run)
        states = self._states = device.allocate("states", tree.texels, np.uint8)
        flags = self._flags = device.allocate("flags", samples, np.uint8)
        ranks = self._ranks = device.allocate("ranks", samples, np.uint32)
        node_counts, node_offsets, row_counts, row_offsets = (
            device.allocate(name, rows, np.uint32)
            for name, rows in (
                ("node_counts", node_runs), ("node_offsets", node_runs),
                ("row_counts", row_runs), ("row_offsets", row_runs),
            )
        )  # fmt: skip
        total = device.allocate("total", 1, np.uint32)
        self._filter = launch(
            "fragment_filter", node_runs, "filter", errors=tree.errors, bounds=tree.bounds,
            states=states, eye_scale=(0, 0, 0, 0), near_slack=(0, 0), threshold=0.0,
        )  # fmt: skip
        marked: dict[str, Any] = {"states": states, "flags": flags}
        self._frame = [
            launch("geometry_mark", row_runs, "mark", run_counts=row_counts, **marked),
            ExclusiveScan(device, row_counts, row_offsets, total, stage="scan"),
            launch(
                "vertex", row_runs, "vertex", flags=flags, image=tree.positions,
                image_normals=tree.normals, states=states, levels=tree.levels,
                offsets=row_offsets, ranks=ranks, positions=self._out_positions,
                normals=self._out_normals, counts=self._counts,
                fitted=int(self.params.placement == "fitted"),
            ),
            launch("geometry_count", node_runs, "count", run_counts=node_counts, **marked),
            ExclusiveScan(device, node_counts, node_offsets, total, stage="scan"),
            launch(
                "geometry_emit", node_runs, "emit", ranks=ranks, offsets=node_offsets,
                triangles=self._out_triangles, counts=self._counts, **marked,
            ),
        ]  # fmt: skip

    def _first_frames(self) -> None:
        """Each kernel once, since the driver compiles at the first launch."""
        self._draw(Detail(), Timeline())
        self._device.wait()
        self.last = None

    @property
    def output(self) -> DeviceSurface:
        """The last frame's surface; its room is that of the full image."""
        return DeviceSurface(
            positions=self._out_positions,
            normals=self._out_normals,
            triangles=self._out_triangles,
            vertex_count=self._out_positions.shape[0],
            triangle_count=self._out_triangles.shape[0],
            counts=self._counts,
        )

    def enqueue(self, frame: Frame, timeline: Timeline) -> None:
        """Filter, mark, count, scan, vertices, triangles; never waits."""
        if self._image is not None:
            self._draw(detail_of(self.tree, self.params, self.threshold, frame.view), timeline)

    def _draw(self, detail: Detail, timeline: Timeline) -> None:
        self.last = detail
        self._filter.set(
            threshold=detail.threshold, eye_scale=detail.eye_scale, near_slack=detail.near_slack
        )
        self._filter(timeline)
        for step in self._frame:
            step(timeline)

    def _live(self) -> tuple[int, int]:
        """Vertices and triangles of the last frame; one is run when there was none."""
        if self._image is not None and self.last is None:
            self.enqueue(Frame(), Timeline())
        vertices, triangles = self._device.read(self._counts)
        return int(vertices), int(triangles)

    def _search(self, target: int) -> float:
        """The smallest threshold with at most `target` triangles, among the nodes' own errors; the tree's units."""
        nodes = [level.ravel() for level in self.tree.read_errors()[1:-1]]
        errors = np.unique(np.concatenate([*nodes, np.zeros(1, np.float32)]))
        # half-way to the next error, so that neither rounding nor other units change what passes
        between = (errors.astype(np.float64) + np.append(errors[1:], 2 * errors[-1] + 1e-30)) / 2
        steps = np.concatenate([np.zeros(1), between])
        low, high = 0, len(steps) - 1
        while low < high:
            middle = (low + high) // 2
            self._draw(Detail(float(steps[middle])), Timeline())
            if self._live()[1] <= target:
                high = middle
            else:
                low = middle + 1
        self.last = None
        return float(steps[low])

    @property
    def states(self) -> list[NDArray[np.uint8]]:
        """Per depth, the last frame's states: 0 too coarse, 1 nothing to draw, 2 drawn."""
        return reference.unpack(self._device.read(self._states), self._n)

    def result(self) -> Sequence[TriangleMesh]:
        """The last frame's surface, with normals."""
        vertices, triangles = self._live()
        return [
            TriangleMesh(
                self._device.read(self._out_positions, vertices),
                self._device.read(self._out_triangles, triangles),
                self._device.read(self._out_normals, vertices),
            )
        ]

    def check(self) -> Check:
        """Errors against float64, and the last frame's triangles against the reference at the same detail."""
        return reference.judge(self)

    @property
    def image(self) -> GeometryImage | None:
        """What is drawn; None when the input had no triangles."""
        return self._image

    def counters(self) -> Mapping[str, int | float]:
        """What the last frame drew."""
        vertices, triangles = self._live()
        if self._image is None:
            return {"vertices": 0, "triangles": 0}
        drawn = [int((level == 2).sum()) for level in self.states]
        return {
            "vertices": vertices,
            "triangles": triangles,
            "nodes": sum(drawn),
            "leaves": drawn[-1],
            "n": self._n,
            "samples": self.tree.side**2,
            "threshold": self.threshold / (self._size or 1.0),
        }

    def _output_bytes(self) -> int:
        buffers = (self._out_positions, self._out_normals, self._out_triangles, self._counts)
        return sum(buffer.size_bytes for buffer in buffers)

    def footprint(self) -> Footprint:
        """Stored is the image with its tree; a static buffer holds the full image's vertices and triangles."""
        if self._image is None:
            return Footprint()
        vertices = 4**self._n + 2
        return Footprint(
            input_bytes=self.tree.input_bytes,
            pattern_bytes=self.tree.tree_bytes,
            output_bytes=self._output_bytes(),
            scratch_bytes=self._scratch,
            stored_vertices=self.tree.side**2,
            stored_bytes=self.tree.input_bytes + self.tree.tree_bytes,
            static_vertices=vertices,
            static_bytes=24 * vertices + 24 * 4**self._n,
        )

    def traffic(self) -> Mapping[str, Traffic]:
        """Each packed texel and sample once per stage that looks at it; vertices and triangles once."""
        if self._image is None:
            return {}
        vertices, triangles = self._live()
        samples, texels = self.tree.side**2, self.tree.texels
        upper = texels // 3
        bound = 16 * upper if self.last is not None and self.last.per_node else 0
        return {
            "filter": Traffic(4 * upper + bound + texels),
            "mark": Traffic(upper + samples),
            "count": Traffic(texels),
            "vertex": Traffic(2 * samples + 52 * vertices),
            "emit": Traffic(texels + 4 * vertices + 12 * triangles),
        }
