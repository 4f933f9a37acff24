"""The pattern is drawn once into buffers that stay; a frame passes them through the vertex stage."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.device import Device, Unsupported
from lodbench.kernels.refine import pattern
from lodbench.kernels.refine.launching import VERTEX_BYTES, group_size, kernel_defines
from lodbench.kernels.refine.pattern.host import Pattern
from lodbench.kernels.stages.timeline import Timeline
from lodbench.kernels.system import Footprint, Frame, Traffic

if TYPE_CHECKING:
    from lodbench.kernels.refine.static_vbo import Params


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> StaticVbo:
    """The refined surface made and stored, and the launch that draws it.

    Raises:
        Unsupported: the stored surface and the output do not both fit the device's memory.
    """
    return StaticVbo(device, mesh, params)


class StaticVbo(Pattern):
    """A refined mesh that stays in memory: see `lodbench.kernels.refine.static_vbo`.

    Its set-up is a whole `Pattern`, whose output becomes the store; the frame is another.
    """

    def __init__(self, device: Device, mesh: TriangleMesh, params: Params) -> None:
        made = pattern.Params(params.segments, amplitude=params.amplitude, waves=params.waves)
        self._launch = None
        super().__init__(device, mesh, made)
        level = self._levels[0]
        vertices = level.surface.vertex_count
        if len(level.batches) > 1:
            raise Unsupported(
                f"needs {VERTEX_BYTES * vertices:,} bytes of device memory to store the surface, "
                f"device has room for {VERTEX_BYTES * self._capacity:,}"
            )
        making = Timeline()
        with self.setup.host("store"):
            self._draw(level, Frame(), making)
            device.wait()
        stored_positions, stored_normals = self._positions, self._normals
        self._positions = device.allocate("positions", (self._capacity, 3), "f4")
        self._normals = device.allocate("normals", (self._capacity, 3), "f4")
        level.surface = replace(level.surface, positions=self._positions, normals=self._normals)
        defines = kernel_defines(device, VERTEX_BYTES * vertices)
        with self.setup.host("build"):
            program = device.build("refine/static_vbo/vertex.cl", defines=defines)
        self._launch = program.launch(
            "static_vbo_vertex",
            -(-vertices // defines["CHUNK"]),
            stage="vertex",
            local=group_size(device),
            stored_positions=stored_positions,
            stored_normals=stored_normals,
            positions=self._positions,
            normals=self._normals,
            vertex_count=vertices,
        )
        with self.setup.host("first_launch"):
            self.enqueue(Frame(), Timeline())
            device.wait()

    def enqueue(self, frame: Frame, timeline: Timeline) -> None:
        """Pass every stored vertex through; neither the eye nor time changes what is stored."""
        if self._launch is not None and self._drawn.surface.vertex_count:
            self._launch(timeline)

    def counters(self) -> Mapping[str, int | float]:
        """What the frame made, and the vertices stored as the paper counts them: a square grid's per triangle."""
        found = dict(super().counters())
        return found | {
            "vertices_square_grid": found["vertices_square_grid"] * self._mesh.triangle_count
        }

    def footprint(self) -> Footprint:
        """Stored are all vertices, with an index list of all triangles."""
        made = super().footprint()
        stored = VERTEX_BYTES * made.static_vertices
        return replace(
            made,
            input_bytes=stored,
            stored_vertices=made.static_vertices,
            stored_bytes=made.static_bytes,
        )

    def traffic(self) -> Mapping[str, Traffic]:
        """Every vertex is read and written."""
        return {"vertex": Traffic(2 * VERTEX_BYTES * self._drawn.surface.vertex_count)}
