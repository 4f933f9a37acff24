"""All surfaces on their grids, in one launch after that of the basis functions."""

from __future__ import annotations

from collections.abc import Mapping

from lodbench.datasets_gen.nurbs_surface import NurbsModel
from lodbench.kernels.launching import group_size, kernel_defines
from lodbench.kernels.nurbs.borders import borders_of
from lodbench.kernels.nurbs.tessellated import Tessellated, sampled
from lodbench.kernels.nurbs.tolerance import within
from lodbench.kernels.nurbs.uniform_nurbs.params import Params
from lodbench.kernels.opencl import Device


class UniformNurbs(Tessellated):
    """A model under uniform tessellation: see `lodbench.kernels.nurbs.uniform_nurbs`."""

    def __init__(self, device: Device, model: NurbsModel, params: Params) -> None:
        largest = None
        if params.tolerance is None:
            samples = sampled(model, params)
        else:
            samples, largest = within(model, borders_of(model), params.tolerance)
        self._largest = largest
        super().__init__(device, model, params, samples)
        size = self.vertex_bytes * self.vertices
        defines = self.defines | kernel_defines(device, size)
        if self.vertices:
            with self.setup.host("build"):
                program = device.build("nurbs/uniform_nurbs/vertex.cl", defines=defines)
            launch = program.launch(
                "uniform_nurbs_vertex", -(-self.vertices // defines["CHUNK"]), stage="vertex",
                local=group_size(device), **self.buffers, positions=self.positions,
                normals=self.normals, stride=self._stride, surface_count=len(model.surfaces),
                vertex_count=self.vertices,
            )  # fmt: skip
            terms = [s.degree_u + s.degree_v + 2 for s in model.surfaces]
            flops = sum(6 * t // 2 * g.vertices for t, g in zip(terms, self.grids, strict=True))
            read = self.buffers["controls"].size_bytes + self.buffers["weights"].size_bytes
            self.add(launch, bytes=size + read, flops=flops)
        self.finish()

    def more_counters(self) -> Mapping[str, int | float]:
        """With a tolerance, also the largest distance that was measured, as a share of the box."""
        found = dict(super().more_counters())
        return found if self._largest is None else found | {"largest_distance": self._largest}
