"""The grid is made once; a frame passes its vertices through."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lodbench.datasets_gen.surfaces import GeometryImage, TriangleMesh
from lodbench.kernels.device import Device
from lodbench.kernels.geometry_image.parameterisation import topology
from lodbench.kernels.geometry_image.quadtree_lod.host import image_of
from lodbench.kernels.geometry_image.uniform_grid.reference import grid
from lodbench.kernels.stages.timeline import Timeline
from lodbench.kernels.system import Check, DeviceSurface, Footprint, Frame, Traffic

if TYPE_CHECKING:
    from lodbench.kernels.geometry_image.uniform_grid import Params

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


class UniformGrid:
    """One grid, stored."""

    def __init__(
        self, device: Device, image: GeometryImage | None, params: Params, setup: Timeline
    ) -> None:
        self._device, self.setup = device, setup
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
            self._stored = [
                device.upload(name, rows)
                for name, rows in (
                    ("stored_positions", made.positions), ("stored_normals", made.normals),
                )
            ]  # fmt: skip
            self._triangles = device.upload("triangles", made.triangles)
        self._positions = device.allocate("positions", made.positions.shape, np.float32)
        self._normals = device.allocate("normals", made.positions.shape, np.float32)
        chunk = CPU_CHUNK if device.is_cpu else GPU_CHUNK
        floats = made.positions.size
        with setup.host("build"):
            program = device.build(
                "geometry_image/uniform_grid/vertex.cl", defines={"CHUNK": chunk}
            )
        self._launch = program.launch(
            "uniform_grid_vertex", -(-floats // chunk), stage="vertex",
            local=1 if device.is_cpu else None, stored_positions=self._stored[0],
            stored_normals=self._stored[1], positions=self._positions, normals=self._normals,
            float_count=floats,
        )  # fmt: skip
        with setup.host("first_launch"):
            self._launch(Timeline())
            device.wait()

    @property
    def output(self) -> DeviceSurface:
        """The grid's surface."""
        vertices, triangles = self._positions.shape[0], self._triangles.shape[0]
        return DeviceSurface(self._positions, self._normals, self._triangles, vertices, triangles)

    def enqueue(self, frame: Frame, timeline: Timeline) -> None:
        """Every vertex passed through; no view changes what is stored."""
        self._launch(timeline)

    def result(self) -> Sequence[TriangleMesh]:
        """The grid, with normals."""
        device = self._device
        return [
            TriangleMesh(
                device.read(self._positions),
                device.read(self._triangles),
                device.read(self._normals),
            )
        ]

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

    def counters(self) -> Mapping[str, int | float]:
        """The grid's size."""
        mesh = self._expected
        return {
            "vertices": mesh.vertex_count, "triangles": mesh.triangle_count, "cells": self.cells,
        }  # fmt: skip

    def footprint(self) -> Footprint:
        """All of it is stored."""
        size = sum(buffer.size_bytes for buffer in (*self._stored, self._triangles))
        vertices = self._expected.vertex_count
        return Footprint(
            input_bytes=size,
            output_bytes=self._positions.size_bytes + self._normals.size_bytes,
            stored_vertices=vertices,
            stored_bytes=size,
            static_vertices=vertices,
            static_bytes=size,
        )

    def traffic(self) -> Mapping[str, Traffic]:
        """Every vertex is read and written."""
        return {"vertex": Traffic(48 * self._expected.vertex_count)}
