"""The parametric map over all patches, in one launch."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels.bezier.arrangement import Arrangement
from lodbench.kernels.bezier.lattice import lattice_triangles, side_vertices, stored_map
from lodbench.kernels.bezier.leveled import Leveled
from lodbench.kernels.bezier.tessellated import CONTROL_FLOATS, Tessellated
from lodbench.kernels.bezier.vst.params import Params
from lodbench.kernels.launching import LINE, group_size, kernel_defines
from lodbench.kernels.opencl import Device, Launch

FLOPS = {False: 24, True: 75}  # of a vertex, counted from the kernel: without normals, and with


def map_arrangement(level: int) -> Arrangement:
    """A patch's virtual vertices in order."""
    return Arrangement(np.arange(side_vertices(level) ** 2), lattice_triangles(level))


def vst(device: Device, patches: BezierPatches, params: Params) -> Vst | Leveled:
    """All patches at one level, or each at its own."""
    if params.is_uniform:
        return Vst(device, patches, params)
    return Leveled(device, patches, params, map_arrangement, _of_level)


def _of_level(own: Leveled, level: int) -> Iterator[Launch]:
    weights = own.upload(f"map_{level}", stored_map(level), role="pattern")
    blocks = -(-side_vertices(level) // 8)
    program = own.device.build("bezier/vst/vertex.cl", defines=own.defines | {"CHUNK": 8})
    yield program.launch(
        "vst_vertex_levels", own.count * blocks, stage="vertex", local=group_size(own.device), map=weights,
        controls=own.controls, levels=own.levels, offsets=own.offsets, positions=own.positions,
        normals=own.normals, map_stride=weights.shape[1], level=level, blocks=blocks, patch_count=own.count,
    )  # fmt: skip


def row_chunk(side: int, most: int) -> int:
    """Vertices of a work-item: blocks of eight whole rows, about `most`; or `most`, where it is a single vector."""
    block = 8 * side
    return most if most <= LINE else block * max(most // block, 1)


class Vst(Tessellated):
    """Patches under vertex shader tessellation: see `lodbench.kernels.bezier.vst`."""

    def __init__(self, device: Device, patches: BezierPatches, params: Params) -> None:
        side = side_vertices(params.level)
        super().__init__(device, patches, params, map_arrangement(params.level))
        with self.setup.host("upload"):
            weights = self.upload_map()
        size = self.vertex_bytes * self.vertices
        defines = kernel_defines(device, size) | {"NORMALS": int(params.normals)}
        chunk = row_chunk(side, defines["CHUNK"])
        if defines["STREAMING"]:
            defines["CHUNK"] = chunk
        with self.setup.host("build"):
            program = device.build("bezier/vst/vertex.cl", defines=defines)
        launch = program.launch(
            "vst_vertex",
            -(-self.vertices // chunk),
            stage="vertex",
            local=group_size(device),
            map=weights,
            controls=self.controls,
            positions=self.positions,
            normals=self.normals,
            map_stride=weights.shape[1],
            side=side,
            chunk=chunk,
            vertex_count=self.vertices,
        )
        read = 4 * (CONTROL_FLOATS * self.count + 8 * side)
        if self.vertices:
            self.add(launch, bytes=size + read, flops=FLOPS[params.normals] * self.vertices)
        self.finish()
