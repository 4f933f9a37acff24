"""A work-item for each zone of each patch, in one launch."""

from __future__ import annotations

from collections.abc import Mapping

from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels.bezier.gst.params import Params
from lodbench.kernels.bezier.gst.zones import largest_zone, zone_arrangement
from lodbench.kernels.bezier.tessellated import CONTROL_FLOATS, Tessellated
from lodbench.kernels.launching import group_size, kernel_defines
from lodbench.kernels.opencl import Device

REUSES = ("none", "zone", "row")
FLOPS = {"none": (170, 330), "zone": (90, 220), "row": (18, 85)}
"""Of a vertex, counted from the kernel: without normals, and with."""


class Gst(Tessellated):
    """Patches under geometry shader tessellation: see `lodbench.kernels.bezier.gst`."""

    def __init__(self, device: Device, patches: BezierPatches, params: Params) -> None:
        self._values = 8 if params.normals else 4
        self._zone = largest_zone(params.level, self._values, params.most_values)
        arrangement = zone_arrangement(params.level, self._zone)
        super().__init__(device, patches, params, arrangement)
        size = self.vertex_bytes * self.vertices
        defines = kernel_defines(device, size if self._zone.vertices % 8 == 0 else 0)
        defines |= {
            "NORMALS": int(params.normals),
            "REUSE": REUSES.index(params.reuse),
            "ZONE_ROWS": self._zone.rows,
            "ZONE_COLUMNS": self._zone.columns,
        }
        with self.setup.host("build"):
            program = device.build("bezier/gst/geometry.cl", defines=defines)
        self._zones = self.vertices // self._zone.vertices
        launch = program.launch(
            "gst_geometry",
            self._zones,
            stage="geometry",
            local=group_size(device),
            controls=self.controls,
            positions=self.positions,
            normals=self.normals,
            segments=1 << params.level,
            zone_count=self._zones,
        )
        if self.vertices:
            flops = FLOPS[params.reuse][params.normals] * self.vertices
            self.add(launch, bytes=size + 4 * CONTROL_FLOATS * self.count, flops=flops)
        self.finish()

    def more_counters(self) -> Mapping[str, int | float]:
        """The zones, and what one of them emits."""
        return {
            **super().more_counters(),
            "zones": self._zones,
            "zone_rows": self._zone.rows,
            "zone_columns": self._zone.columns,
            "zone_values": self._zone.vertices * self._values,
        }
