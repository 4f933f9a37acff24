"""The pattern is drawn once into buffers that stay; a frame passes them through the vertex stage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.launching import VERTEX_BYTES, group_size, kernel_defines
from lodbench.kernels.opencl import Device, Unsupported
from lodbench.kernels.refine.params import LevelParams, RefineParams
from lodbench.kernels.refine.refined import Refined
from lodbench.kernels.refine.static_vbo.params import Params
from lodbench.kernels.refine.surfaces import chosen_surface
from lodbench.kernels.subject import Step
from lodbench.kernels.system import Frame, Stored


class StaticVbo(Refined):
    """A refined mesh that stays in memory: its set-up is refinement by one pattern, whose output becomes the store.

    Raises:
        ValueError: a coordinate or a tag that the surface cannot bear.
        Unsupported: the stored surface and the output do not both fit the device's memory.
    """

    def __init__(self, device: Device, mesh: TriangleMesh, params: Params) -> None:
        made = LevelParams(**{f.name: getattr(params, f.name) for f in fields(RefineParams)})
        super().__init__(device, mesh, made, chosen_surface(params))
        level = self._levels[0]
        vertices = level.surface.vertex_count
        if len(level.batches) > 1:
            raise Unsupported(
                f"needs {VERTEX_BYTES * vertices:,} bytes of device memory to store the surface, "
                f"device has room for {VERTEX_BYTES * self._capacity:,}"
            )
        self.setup.stage_s["store"] = self.setup.stage_s.pop("first_launch")  # the pattern's
        stored_positions, stored_normals = self._positions, self._normals
        self._bytes["input"] = self._bytes.pop("output")
        self._allocate_output()
        level.surface = replace(level.surface, positions=self._positions, normals=self._normals)
        self.output = (level.surface,)
        defines = kernel_defines(device, VERTEX_BYTES * vertices)
        with self.setup.host("build"):
            program = device.build("refine/static_vbo/vertex.cl", defines=defines)
        launch = program.launch(
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
        if vertices:
            self.add(launch, bytes=2 * VERTEX_BYTES * vertices)
        self.warm_up()

    def steps(self, frame: Frame) -> Sequence[Step]:
        """Every stored vertex passed through; neither the eye nor time changes what is stored."""
        return self._steps if self._steps else super().steps(frame)

    def more_counters(self) -> Mapping[str, int | float]:
        """As the pattern's; the vertices stored as the paper counts them are a square grid's per triangle."""
        found = dict(super().more_counters())
        found["vertices_square_grid"] *= self._mesh.triangle_count
        return found

    def stored(self) -> Stored:
        """Stored are all vertices, with an index list of all triangles."""
        static = super().stored()
        return replace(
            static, stored_vertices=static.static_vertices, stored_bytes=static.static_bytes
        )
