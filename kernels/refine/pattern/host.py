"""The flat surface under patterns; and, as the paper drew it, a launch per coarse triangle."""

from __future__ import annotations

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.launching import group_size
from lodbench.kernels.opencl import Device, Launch, Program
from lodbench.kernels.refine.levels import Batch, Level
from lodbench.kernels.refine.pattern.params import Params
from lodbench.kernels.refine.pattern.surface import Flat
from lodbench.kernels.refine.refined import Refined


class Pattern(Refined):
    """A mesh under generic refinement: see `lodbench.kernels.refine.pattern`."""

    def __init__(self, device: Device, mesh: TriangleMesh, params: Params) -> None:
        self._single_draws = params.draw == "per_triangle"
        if self._single_draws:
            self.more_files = ("refine/pattern/vertex.cl",)
        super().__init__(device, mesh, params, Flat())

    def _launches(self, program: Program, level: Level, batch: Batch) -> list[Launch]:
        if not self._single_draws:
            return super()._launches(program, level, batch)
        return [self._single(program, level, place, batch) for place in range(batch.count)]

    def _single(self, program: Program, level: Level, place: int, batch: Batch) -> Launch:
        first = place * level.vertices
        corners = self._coarse.corners[batch.first + place]
        points, normals = corners[:9].reshape(3, 3), corners[9:18].reshape(3, 3)
        return program.launch(
            "pattern_vertex_single",
            (first + level.vertices - 1) // self._chunk - first // self._chunk + 1,
            stage="vertex",
            local=group_size(self.device),
            first_vertex=first,
            triangle=batch.first + place,
            **{f"p{k}": (*points[k], corners[18]) for k in range(3)},
            **{f"n{k}": (*normals[k], 0) for k in range(3)},
            **self._arguments(level),
        )
