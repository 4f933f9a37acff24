"""What the subjects share that draw the pattern once per coarse triangle, instanced: a vertex shader each."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.harness.baselines.gl.driver import build
from lodbench.harness.baselines.gl.refined import Refined
from lodbench.kernels.refine.lattice import lattice_triangles, lattice_weights


class Instanced(Refined):
    """The pattern's weights per vertex, what `instances` gives per coarse triangle.

    Attributes:
        shader: the vertex shader's file.
    """

    shader: str

    def programs(self) -> tuple[Any, Any]:
        kept = ("surface_position", "shaded_normal")
        return build(self.shader, "surface.frag"), build(self.shader, varyings=kept)

    @abstractmethod
    def instances(self) -> dict[tuple[str, ...], NDArray[np.float32]]:
        """Names of the shader's attributes, and their values one after the other in a row per coarse triangle."""

    def upload(self) -> None:
        segments = self.params.segments
        weights = lattice_weights(segments)[:, 1:].astype(np.float32)
        self._vertices = len(weights)
        arrays: list[tuple[Any, ...]] = [(self.buffer(weights), "2f", "weights")]
        for names, values in self.instances().items():
            each = values[0].size // len(names)
            form = " ".join([f"{each}f"] * len(names))
            arrays.append((self.buffer(values), f"{form}/i", *names))
        triangles = self.buffer(lattice_triangles(segments))
        self._array = self.gl.vertex_array(self.draw_program, arrays, triangles)
        self._points = self.gl.vertex_array(self.feedback_program, arrays)

    def draw(self, coarse: int) -> None:
        self._array.render(instances=coarse)

    def keep(self, buffer: Any) -> None:
        self._points.transform(
            buffer, mode=self.gl.POINTS, vertices=self._vertices, instances=self.coarse
        )
