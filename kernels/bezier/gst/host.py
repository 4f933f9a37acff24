"""A work-item for each zone of each patch, in one launch."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels.bezier.gst.params import Params
from lodbench.kernels.bezier.gst.zones import Zone, largest_zone, zone_arrangement
from lodbench.kernels.bezier.leveled import Leveled
from lodbench.kernels.bezier.tessellated import CONTROL_FLOATS, Tessellated
from lodbench.kernels.launching import group_size, kernel_defines
from lodbench.kernels.opencl import Device, Launch

REUSES = ("none", "zone", "row")
FLOPS = {"none": (170, 330), "zone": (90, 220), "row": (18, 85)}
"""Of a vertex, counted from the kernel: without normals, and with."""


def gst(device: Device, patches: BezierPatches, params: Params) -> Gst | Leveled:
    """All patches at one level, or each at its own."""
    if params.is_uniform:
        return Gst(device, patches, params)

    def zone(level: int) -> Zone:
        return largest_zone(level, 8 if params.normals else 4, params.most_values)

    def of_level(own: Leveled, level: int) -> Iterator[Launch]:
        found = zone(level)
        defines = own.defines | _zone_defines(found, params)
        program = device.build("bezier/gst/geometry.cl", defines=defines)
        yield program.launch(
            "gst_geometry_levels", own.count * (4**level // (found.rows * found.columns)), stage="geometry",
            local=group_size(device), controls=own.controls, levels=own.levels, offsets=own.offsets,
            positions=own.positions, normals=own.normals, level=level, patch_count=own.count,
        )  # fmt: skip

    return Leveled(
        device, patches, params, lambda level: zone_arrangement(level, zone(level)), of_level
    )


def _zone_defines(zone: Zone, params: Params) -> dict[str, int]:
    return {
        "NORMALS": int(params.normals),
        "REUSE": REUSES.index(params.reuse),
        "ZONE_ROWS": zone.rows,
        "ZONE_COLUMNS": zone.columns,
    }


class Gst(Tessellated):
    """Patches under geometry shader tessellation: see `lodbench.kernels.bezier.gst`."""

    def __init__(self, device: Device, patches: BezierPatches, params: Params) -> None:
        self._values = 8 if params.normals else 4
        self._zone = largest_zone(params.level, self._values, params.most_values)
        arrangement = zone_arrangement(params.level, self._zone)
        super().__init__(device, patches, params, arrangement)
        size = self.vertex_bytes * self.vertices
        defines = kernel_defines(device, size if self._zone.vertices % 8 == 0 else 0)
        defines |= _zone_defines(self._zone, params)
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
