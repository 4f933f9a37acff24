"""The grid is made once; a frame passes its vertices through."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from lodbench.datasets_gen.surfaces import GeometryImage, TriangleMesh
from lodbench.kernels.geometry_image.parameterisation import topology
from lodbench.kernels.geometry_image.quadtree_lod.host import image_of
from lodbench.kernels.geometry_image.uniform_grid.params import Params
from lodbench.kernels.geometry_image.uniform_grid.reference import grid
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.subject import POINT, DeviceSubject
from lodbench.kernels.system import Check, DeviceSurface

CPU_CHUNK, GPU_CHUNK = 4096, 16


def prepare(device: Device, mesh: TriangleMesh | GeometryImage, params: Params) -> UniformGrid:
    """The grid on the device, made of an image, or of the image of a triangle mesh.

    Raises:
        NotSpherical: the mesh is not one closed surface of genus 0.
        Unsupported: no room.
    """
    setup = Timeline()
    params = params.counted(mesh.triangle_count)
    image = image_of(device, mesh, params.layout(), setup)
    return UniformGrid(device, image, params, setup)


class UniformGrid(DeviceSubject):
    """One grid, stored; no view changes what is drawn."""

    def __init__(
        self, device: Device, image: GeometryImage | None, params: Params, setup: Timeline
    ) -> None:
        super().__init__(device, setup)
        self.cells = 0
        self._expected = TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int), np.zeros((0, 3)))
        if image is not None:
            self.cells = params.cells or image.positions.shape[0] - 1
            if params.target_count is not None:
                self.cells = max(2 * (math.isqrt(params.target_count // 2) // 2), 2)
            with setup.host("store"):
                self._expected = grid(image, self.cells)
        made = self._expected
        with setup.host("upload"):
            assert made.normals is not None
            stored_positions = self.upload("stored_positions", made.positions)
            stored_normals = self.upload("stored_normals", made.normals)
            triangles = self.upload("triangles", made.triangles)
        positions = self.allocate("positions", made.positions.shape, np.float32, "output")
        normals = self.allocate("normals", made.positions.shape, np.float32, "output")
        vertices = made.vertex_count
        self.output = (DeviceSurface(positions, normals, triangles, vertices, made.triangle_count),)
        chunk = CPU_CHUNK if device.is_cpu else GPU_CHUNK
        with setup.host("build"):
            program = device.build(
                "geometry_image/uniform_grid/vertex.cl", defines={"CHUNK": chunk}
            )
        launch = program.launch(
            "uniform_grid_vertex", -(-3 * vertices // chunk), stage="vertex",
            local=1 if device.is_cpu else None, stored_positions=stored_positions,
            stored_normals=stored_normals, positions=positions, normals=normals,
            float_count=3 * vertices,
        )  # fmt: skip
        self.add(launch, bytes=4 * POINT * vertices)
        self.warm_up()

    def check(self) -> Check:
        """Positions, normals and triangles against the stored ones, and what the triangles enclose."""
        (mesh,) = self.result()
        rows = [
            getattr(mesh, name) != getattr(self._expected, name)
            for name in ("positions", "normals", "triangles")
        ]
        wrong = sum(int(different.any(axis=1).sum()) for different in rows)
        if mesh.triangle_count:
            wrong += len(topology(mesh.triangles).faults)
        what = "rows that differ from what is stored, and faults of a closed surface"
        return Check(wrong == 0, what, float(wrong), 0.0)

    def more_counters(self) -> Mapping[str, int | float]:
        """Cells along a side."""
        return {"cells": self.cells}
