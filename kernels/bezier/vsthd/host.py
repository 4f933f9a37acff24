"""A launch for every few patches, each with the control points that it reads."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels.bezier.lattice import side_vertices, stored_map
from lodbench.kernels.bezier.leveled import Leveled
from lodbench.kernels.bezier.tessellated import CONTROL_FLOATS, Tessellated, control_rows
from lodbench.kernels.bezier.vst.host import FLOPS, map_arrangement
from lodbench.kernels.bezier.vsthd.params import Params
from lodbench.kernels.bezier.vsthd.reference import map_bytes, uniform_vectors
from lodbench.kernels.launching import group_size, kernel_defines
from lodbench.kernels.opencl import Buffer, Device, Launch, Unsupported
from lodbench.kernels.opencl.image import upload_image
from lodbench.kernels.subject import DeviceSubject

PATCH_BYTES = 4 * CONTROL_FLOATS


def check_room(device: Device, params: Params) -> None:
    """Refuse draws of more patches than constant memory holds.

    Raises:
        Unsupported: it holds fewer.
    """
    most, needed = device.handle.max_constant_buffer_size, params.surfaces_per_draw * PATCH_BYTES
    if params.memory == "uniform" and needed > most:
        needs = f"needs {needed:,} bytes of constant memory"
        raise Unsupported(f"surfaces_per_draw: {needs}, device has {most:,}")


def draws_of(
    own: DeviceSubject, patches: BezierPatches, params: Params, controls: Buffer
) -> Iterator[tuple[int, int, dict[str, Any]]]:
    """The first patch of each draw, how many it has, and the argument that it reads them from."""
    rows, texels = control_rows(patches.points), None
    if params.memory == "texture" and len(rows):
        with own.setup.host("upload"):
            texels = upload_image(own.device, "texels", rows.reshape(-1, 16, 4))
            own.hold("input", texels)
    for first in range(0, len(rows), params.surfaces_per_draw):
        part = rows[first : first + params.surfaces_per_draw]
        read: dict[str, Any] = {"controls": controls}
        if params.memory == "uniform":
            read = {"uniforms": own.upload("uniforms", part)}
        elif params.memory == "texture":
            read = {"texels": texels}
        yield first, len(part), read


def vsthd(device: Device, patches: BezierPatches, params: Params) -> Vsthd | Leveled:
    """All patches at one level, or each at its own: then a draw is made for each level."""
    if params.is_uniform:
        return Vsthd(device, patches, params)
    check_room(device, params)
    draws: list[tuple[int, int, dict[str, Any]]] = []

    def of_level(own: Leveled, level: int) -> Iterator[Launch]:
        if not draws:
            draws.extend(draws_of(own, patches, params, own.controls))
        weights = own.upload(f"map_{level}", stored_map(level), role="pattern")
        blocks = -(-side_vertices(level) // 8)
        program = device.build("bezier/vsthd/vertex.cl", defines=own.defines | {"CHUNK": 8})
        for first, count, read in draws:
            yield program.launch(
                f"vsthd_vertex_levels_{params.memory}", count * blocks, stage="vertex", local=group_size(device),
                map=weights, levels=own.levels, offsets=own.offsets, positions=own.positions,
                normals=own.normals, map_stride=weights.shape[1], level=level, blocks=blocks,
                first_patch=first, patch_count=count, **read,
            )  # fmt: skip

    return Leveled(device, patches, params, map_arrangement, of_level)


class Vsthd(Tessellated):
    """Patches under handheld tessellation: see `lodbench.kernels.bezier.vsthd`.

    Raises:
        Unsupported: the device has no constant memory for so many patches of a draw, or no such image.
    """

    def __init__(self, device: Device, patches: BezierPatches, params: Params) -> None:
        super().__init__(device, patches, params, map_arrangement(params.level))
        self._each = params.surfaces_per_draw
        check_room(device, params)
        side = side_vertices(params.level)
        with self.setup.host("upload"):
            weights = self.upload_map()
        defines = kernel_defines(device, 0) | {"NORMALS": int(params.normals)}
        with self.setup.host("build"):
            program = device.build("bezier/vsthd/vertex.cl", defines=defines)
        for first, count, read in draws_of(self, patches, params, self.controls):
            vertices = count * side * side
            launch = program.launch(
                f"vsthd_vertex_{params.memory}",
                -(-vertices // defines["CHUNK"]),
                stage="vertex",
                local=group_size(device),
                map=weights,
                positions=self.positions,
                normals=self.normals,
                map_stride=weights.shape[1],
                side=side,
                first_patch=first,
                vertex_count=vertices,
                **read,
            )
            size = self.vertex_bytes * vertices + PATCH_BYTES * count + 32 * side
            self.add(launch, bytes=size, flops=FLOPS[params.normals] * vertices)
        self.draws = len(self._steps)
        self.finish()

    def more_counters(self) -> Mapping[str, int | float]:
        """Draws, and what one of them needs: the thesis's NDP, its vertex buffer, its uniforms."""
        each = self._each
        return {
            **super().more_counters(),
            "draws": self.draws,
            "map_bytes": map_bytes(self._params.level, each),
            "uniform_vectors": uniform_vectors(each),
        }
