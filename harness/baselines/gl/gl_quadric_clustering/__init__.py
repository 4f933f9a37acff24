"""Quadric vertex clustering in an OpenGL driver's shaders, in the three passes that were published.

Pass 1 emits a point per corner into a map of cells, four float render targets that blending adds up; pass 2 solves in a
full-screen fragment shader; pass 3 streams the surviving triangles out of a geometry shader.

Source: DeCoro & Tatarchuk, Real-time Mesh Simplification Using the GPU, I3D 2007, slides 10-17.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, get_args

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.gl.driver import assign, build, context
from lodbench.harness.baselines.host import HostPrepared
from lodbench.harness.baselines.simplifier import found_grid, unchanged
from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.cluster.quadric_clustering import Params as KernelParams
from lodbench.kernels.cluster.quadric_clustering.params import Placement
from lodbench.kernels.cluster.quadric_clustering.reference import simplify
from lodbench.kernels.cluster.quadric_clustering.verdict import verdict
from lodbench.kernels.cluster.survivors import host_survivors
from lodbench.kernels.cluster.target import GridTarget
from lodbench.kernels.opencl import Device, Timeline, Unsupported
from lodbench.kernels.system import Check, Footprint, Frame, System, Traffic

STAGE = "draw"
PLACEMENTS: tuple[str, ...] = get_args(Placement)
RECORD = np.dtype([("point", "3f4"), ("cell", "i4")])


@dataclass(frozen=True)
class Params(GridTarget):
    """How far and how to simplify; the words mean what they mean for the kernels.

    Attributes:
        placement: "robust", "paper" or "average".
    """

    placement: Placement = "robust"


class QuadricClustering:
    """Mesh, map and stream-out buffer in the driver, ready for any number of frames."""

    output: tuple[()] = ()

    def __init__(
        self,
        mesh: TriangleMesh,
        params: Params,
        setup: Timeline,
        counters: Mapping[str, int | float],
    ) -> None:
        self.setup = setup
        self._mesh, self._params, self._searched = mesh, params, counters
        self._grid = grid = Grid.over(*mesh.box, params.grid_cells)
        with self.setup.host("context"):
            gl = self._gl = context()
        if gl.version_code < 400:
            raise Unsupported(f"needs OpenGL 4.0, driver has {gl.version_code / 100}")
        width = max(math.isqrt(grid.cell_count - 1) + 1, 1)
        size = (width, -(-grid.cell_count // width))
        most = int(gl.info["GL_MAX_TEXTURE_SIZE"])
        if max(size) > most:
            raise Unsupported(f"needs a map of {size[0]} x {size[1]} texels, driver has {most}")
        with self.setup.host("build"):
            self._map_program = build("cluster.vert", "cluster_map.geom", "cluster_map.frag")
            self._solve_program = build("background.vert", "cluster_solve.frag")
            self._decimate_program = build(
                "cluster.vert", "cluster_decimate.geom", varyings=("kept_point", "kept_cell")
            )
        with self.setup.host("upload"):
            self._targets = [gl.texture(size, 4, dtype="f4") for _ in range(4)]
            self._map = gl.framebuffer(self._targets)
            self._solved = gl.texture(size, 4, dtype="f4")
            self._solving = gl.framebuffer([self._solved])
            self._upload(size)
        with self.setup.host("first_launch"):
            self.enqueue(Frame(), Timeline())

    def _upload(self, size: tuple[int, int]) -> None:
        gl, mesh, grid = self._gl, self._mesh, self._grid
        uniforms = {
            "low": (*map(float, grid.low), grid.prescale),
            "per_axis": (*map(float, grid.per_axis), float(grid.inverse)),
            "cells": grid.counts,
            "map_size": size,
            "placement": PLACEMENTS.index(self._params.placement),
            "per_box": 1 / grid.extent if grid.extent else 1.0,
            "corner_sums": 0, "quadrics_0": 1, "quadrics_1": 2, "quadrics_2": 3,
            "representatives": 4,
        }  # fmt: skip
        for program in (self._map_program, self._solve_program, self._decimate_program):
            assign(program, uniforms)
        self._screen = gl.vertex_array(self._solve_program, [])
        self._kept = None
        if mesh.triangle_count:
            arrays = [(gl.buffer(mesh.positions.tobytes()), "3f", "position")]
            indices = gl.buffer(mesh.triangles.tobytes())
            self._mapping = gl.vertex_array(self._map_program, arrays, indices)
            self._decimating = gl.vertex_array(self._decimate_program, arrays, indices)
            self._kept = gl.buffer(reserve=3 * RECORD.itemsize * mesh.triangle_count)
        self._query = gl.query(primitives=True)
        self._bytes = mesh.positions.nbytes + mesh.triangles.nbytes
        self._texels = size[0] * size[1]

    def enqueue(self, frame: Frame, timeline: Timeline) -> None:
        """The three passes, and the wait until they are done."""
        with timeline.host(STAGE):
            gl = context()
            if self._kept is not None:
                self._passes(gl)
                gl.finish()

    def _passes(self, gl: Any) -> None:
        gl.disable(gl.DEPTH_TEST | gl.CULL_FACE)
        self._map.use()
        self._map.clear()
        gl.enable(gl.BLEND)
        gl.blend_func = gl.ONE, gl.ONE
        self._mapping.render(gl.TRIANGLES)
        gl.disable(gl.BLEND)
        self._solving.use()
        for unit, texture in enumerate(self._targets):
            texture.use(unit)
        self._screen.render(gl.TRIANGLES, vertices=3)
        self._map.use()  # not the target that pass 3 reads
        self._solved.use(4)
        with self._query:
            self._decimating.transform(self._kept, mode=gl.TRIANGLES)

    def result(self) -> Sequence[TriangleMesh]:
        """The streamed-out triangles, indexed by cell: vertices in ascending cell order, triangles in input order."""
        if self._kept is None:
            return [TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), np.uint32))]
        gl = context()
        gl.finish()
        count = 3 * int(self._query.primitives)
        kept = np.frombuffer(self._kept.read(count * RECORD.itemsize) if count else b"", RECORD)
        _, first, triangles = np.unique(kept["cell"], return_index=True, return_inverse=True)
        points = self._grid.positions(kept["point"][first])
        return [TriangleMesh(points, triangles.reshape(-1, 3).astype(np.uint32))]

    def check(self) -> Check:
        """Against the float64 reference: the same triangles, and how far representatives are off."""
        wanted = KernelParams(self._params.cells, self._params.placement, border="none")
        return verdict(self.result()[0], simplify(self._mesh, wanted))

    def counters(self) -> Mapping[str, int | float]:
        """What came out."""
        mesh = self.result()[0]
        return {
            "vertices": mesh.vertex_count,
            "triangles": mesh.triangle_count,
            "cells": self._grid.cell_count,
            **self._searched,
        }

    def footprint(self) -> Footprint:
        """What the passes hold in the driver, as far as we asked for it."""
        stored = 3 * RECORD.itemsize * self._mesh.triangle_count
        return Footprint(
            input_bytes=self._bytes, output_bytes=stored, scratch_bytes=16 * 5 * self._texels
        )

    def traffic(self) -> Mapping[str, Traffic]:
        """Nothing: what the driver moves is not known."""
        return {}


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> QuadricClustering | HostPrepared:
    """The grid found, and the mesh and the maps in the driver.

    Raises:
        Unsupported: no OpenGL 4.0 driver, or a grid too large for its textures.
    """
    setup = Timeline()
    with setup.host("search"):
        cells, counters = found_grid(mesh, params, host_survivors(mesh))
    if cells is None:
        return unchanged(device, mesh, setup, counters)
    params = replace(params, target_reduction=None, target_count=None, cells=cells)
    return QuadricClustering(mesh, params, setup, counters)


SYSTEM = System(
    name="gl_quadric_clustering",
    family="baselines",
    source="DeCoro & Tatarchuk 2007, slides 10-17, on an OpenGL driver",
    takes=(TriangleMesh,),
    prepare=prepare,
    cases={
        "cells_64": Params(64),
        "average_64": Params(64, "average"),
        "paper_64": Params(64, "paper"),
    },
    runs_on="gl",
)
