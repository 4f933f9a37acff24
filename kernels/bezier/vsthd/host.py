"""A launch for every few patches, each with the control points that it reads."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels.bezier.lattice import side_vertices
from lodbench.kernels.bezier.tessellated import CONTROL_FLOATS, Tessellated, control_rows
from lodbench.kernels.bezier.vst.host import FLOPS, map_arrangement
from lodbench.kernels.bezier.vsthd.params import Params
from lodbench.kernels.bezier.vsthd.reference import map_bytes, uniform_vectors
from lodbench.kernels.launching import group_size, kernel_defines
from lodbench.kernels.opencl import Device, Unsupported
from lodbench.kernels.opencl.image import upload_image

PATCH_BYTES = 4 * CONTROL_FLOATS


class Vsthd(Tessellated):
    """Patches under handheld tessellation: see `lodbench.kernels.bezier.vsthd`.

    Raises:
        Unsupported: the device has no constant memory for so many patches of a draw, or no such image.
    """

    def __init__(self, device: Device, patches: BezierPatches, params: Params) -> None:
        super().__init__(device, patches, params, map_arrangement(params.level))
        self._each = each = params.surfaces_per_draw
        memory = params.memory
        most = device.handle.max_constant_buffer_size
        if memory == "uniform" and each * PATCH_BYTES > most:
            needs = f"needs {each * PATCH_BYTES:,} bytes of constant memory"
            raise Unsupported(f"surfaces_per_draw: {needs}, device has {most:,}")
        side = side_vertices(params.level)
        with self.setup.host("upload"):
            weights = self.upload_map()
        defines = kernel_defines(device, 0) | {"NORMALS": int(params.normals)}
        with self.setup.host("build"):
            program = device.build("bezier/vsthd/vertex.cl", defines=defines)
        rows = control_rows(patches.points)
        texels = None
        if memory == "texture" and self.count:
            with self.setup.host("upload"):
                texels = upload_image(device, "texels", rows.reshape(-1, 16, 4))
                self.hold("input", texels)
        for first in range(0, self.count, each):
            count = min(each, self.count - first)
            read: dict[str, Any] = {"controls": self.controls}
            if memory == "uniform":
                own = self.upload("uniforms", rows[first : first + count])
                read = {"uniforms": own}
            elif memory == "texture":
                read = {"texels": texels}
            vertices = count * side * side
            launch = program.launch(
                f"vsthd_vertex_{memory}",
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
