"""A geometry image on a device: its quadtree, and the launches that draw it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import GeometryImage, TriangleMesh
from lodbench.kernels.geometry_image import parameterisation
from lodbench.kernels.geometry_image.quadtree_lod import reference
from lodbench.kernels.geometry_image.quadtree_lod.params import Params
from lodbench.kernels.geometry_image.quadtree_lod.tree import FOLDER, Tree
from lodbench.kernels.geometry_image.quadtree_lod.verdict import verdict
from lodbench.kernels.geometry_image.quadtree_lod.view import LodCriterion, criterion_of
from lodbench.kernels.opencl import Buffer, Device, Launch, Timeline
from lodbench.kernels.stages.scan import ExclusiveScan
from lodbench.kernels.subject import POINT, DeviceSubject, Step
from lodbench.kernels.system import Check, DeviceSurface, Frame, Stored

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


class QuadtreeLod(DeviceSubject):
    """One geometry image; `enqueue` leaves the surface that the frame asks for in `output`.

    Without an image there is nothing to draw: no triangles in, no triangles out.
    """

    def __init__(
        self, device: Device, image: GeometryImage | None, params: Params, setup: Timeline
    ) -> None:
        super().__init__(device, setup)
        self.image, self.params = image, params
        self.last: LodCriterion | None = None
        n = 0 if image is None else (image.positions.shape[0] - 1).bit_length() - 1
        vertices, triangles = (1, 1) if image is None else (4**n + 2, 2 * 4**n)
        self._positions = self.allocate("positions", (vertices, 3), np.float32, "output")
        self._normals = self.allocate("normals", (vertices, 3), np.float32, "output")
        self._triangles = self.allocate("triangles", (triangles, 3), np.uint32, "output")
        self._counts = self.allocate("counts", 2, np.uint32, "output")
        surface = DeviceSurface(
            self._positions,
            self._normals,
            self._triangles,
            vertices,
            triangles,
            counts=self._counts,
        )
        self.output = (surface,)
        if image is None:
            device.fill(Timeline(), "upload", self._counts, 0)
            return
        tree = self.tree = Tree(device, image, params.placement, params.error_metric, setup)
        self.hold("input", tree.positions, tree.normals)
        self.hold("pattern", tree.levels, tree.errors, tree.bounds)
        self._size = tree.diagonal * tree.scale  # the diagonal in the tree's units
        self.threshold = params.threshold * self._size
        with setup.host("build"):
            self._make_frame()
        with setup.host("first_launch"):
            self._draw(LodCriterion())
            device.wait()
        if params.target_count is not None:
            with setup.host("search"):
                self.threshold = self._search(params.target_count)

    def _make_frame(self) -> None:
        device, tree = self.device, self.tree
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
        states = self._states = self.allocate("states", tree.texels, np.uint8)
        flags = self._flags = self.allocate("flags", samples, np.uint8)
        ranks = self._ranks = self.allocate("ranks", samples, np.uint32)
        node_counts, node_offsets, row_counts, row_offsets = (
            self.allocate(name, rows, np.uint32)
            for name, rows in (
                ("node_counts", node_runs), ("node_offsets", node_runs),
                ("row_counts", row_runs), ("row_offsets", row_runs),
            )
        )  # fmt: skip
        total = self.allocate("total", 1, np.uint32)
        upper = tree.texels // 3
        self._filter = launch(
            "fragment_filter", node_runs, "filter", errors=tree.errors, bounds=tree.bounds,
            states=states, eye_scale=(0, 0, 0, 0), near_slack=(0, 0), threshold=0.0,
        )  # fmt: skip
        marked: dict[str, Any] = {"states": states, "flags": flags}
        self.add(self._filter, lambda own: 4 * upper + tree.texels + 16 * upper * own._per_node)
        self.add(
            launch("geometry_mark", row_runs, "mark", run_counts=row_counts, **marked),
            upper + samples,
        )
        self._add_scan(row_counts, row_offsets, total)
        self.add(
            launch(
                "vertex", row_runs, "vertex", flags=flags, image=tree.positions,
                image_normals=tree.normals, states=states, levels=tree.levels,
                offsets=row_offsets, ranks=ranks, positions=self._positions,
                normals=self._normals, counts=self._counts,
                fitted=int(self.params.placement == "fitted"),
            ),
            lambda own: 2 * samples + 52 * own.live()[0],
        )  # fmt: skip
        self.add(
            launch("geometry_count", node_runs, "count", run_counts=node_counts, **marked),
            tree.texels,
        )
        self._add_scan(node_counts, node_offsets, total)
        self.add(
            launch(
                "geometry_emit", node_runs, "emit", ranks=ranks, offsets=node_offsets,
                triangles=self._triangles, counts=self._counts, **marked,
            ),
            lambda own: tree.texels + 4 * own.live()[0] + POINT * own.live()[1],
        )  # fmt: skip

    def _add_scan(self, counts: Buffer, offsets: Buffer, total: Buffer) -> None:
        with self.holding("scratch"):
            self.add(ExclusiveScan(self.device, counts, offsets, total), stage="scan")

    @property
    def _per_node(self) -> bool:
        """Did the last frame ask each node for an error of its own?"""
        return self.last is not None and self.last.per_node

    def steps(self, frame: Frame) -> Sequence[Step]:
        """Filter, mark, count, scan, vertices, triangles, at the detail that the frame's view asks for."""
        if self.image is not None:
            self._aim(criterion_of(self.tree, self.params, self.threshold, frame.view))
        return self._steps

    def _aim(self, criterion: LodCriterion) -> None:
        """Have the steps draw this detail."""
        self.last = criterion
        self._filter.set(
            threshold=criterion.threshold,
            eye_scale=criterion.eye_scale,
            near_slack=criterion.near_slack,
        )

    def _draw(self, criterion: LodCriterion) -> None:
        """The steps at this detail, outside any frame."""
        self._aim(criterion)
        for step in self._steps:
            step.enqueue(Timeline())

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
            self._draw(LodCriterion(float(steps[middle])))
            if int(self.device.read(self._counts)[1]) <= target:
                high = middle
            else:
                low = middle + 1
        return float(steps[low])

    @property
    def states(self) -> list[NDArray[np.uint8]]:
        """Per depth, the last frame's states: 0 too coarse, 1 nothing to draw, 2 drawn."""
        self.live()
        return reference.unpack(self.device.read(self._states), self.tree.n)

    def check(self) -> Check:
        """Errors against float64, and the last frame's triangles against the reference at the same detail."""
        self.live()
        return verdict(self)  # pyright: ignore[reportArgumentType]

    def more_counters(self) -> Mapping[str, int | float]:
        """Nodes drawn, the leaves among them, the image's size and the threshold, in diagonals."""
        if self.image is None:
            return {}
        drawn = [int((level == 2).sum()) for level in self.states]
        return {
            "nodes": sum(drawn),
            "leaves": drawn[-1],
            "n": self.tree.n,
            "samples": self.tree.side**2,
            "threshold": self.threshold / (self._size or 1.0),
        }

    def stored(self) -> Stored:
        """Stored is the image with its tree; a static buffer holds the full image's vertices and triangles."""
        if self.image is None:
            return Stored(0, 0, 0, 0)
        (surface,) = self.output
        vertices, triangles = surface.vertex_count, surface.triangle_count
        return Stored(
            stored_vertices=self.tree.side**2,
            stored_bytes=self._bytes["input"] + self._bytes["pattern"],
            static_vertices=vertices,
            static_bytes=2 * POINT * vertices + POINT * triangles,
        )
