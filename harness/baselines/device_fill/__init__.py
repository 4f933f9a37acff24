"""As many bytes as a refined surface has, filled with one value: nothing that writes them can be faster.

Interleaved with a subject in a table, it shows what share of the device's writing speed that subject reaches.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.limits import VECTOR, sweep
from lodbench.kernels.device import Device
from lodbench.kernels.parameters import Parameters, Range
from lodbench.kernels.refine.lattice import Segments
from lodbench.kernels.stages.timeline import Timeline
from lodbench.kernels.system import Check, Footprint, Frame, System, Traffic

__all__ = ["SYSTEM", "DeviceFill", "Params"]

VALUE = 1.0
VERTEX_BYTES = 24  # a position and a normal of packed floats


@dataclass(frozen=True)
class Params(Parameters):
    """How much is filled, and by what.

    Attributes:
        size_bytes: bytes to fill; None: the positions and normals of the mesh with every triangle refined to
            `segments` per edge, 24 * (n + 1)(n + 2) / 2 bytes per triangle.
        segments: segments per edge, at least 1; only for `size_bytes` None.
        by: "driver" the driver's fill command, "kernel" a vector kernel, "streaming" the same with stores that bypass
            the caches.
    """

    size_bytes: Annotated[int, Range(0)] | None = None
    segments: Segments = 16
    by: Literal["driver", "kernel", "streaming"] = "kernel"


class DeviceFill:
    """One fill of one buffer per frame; its size is rounded up to a whole float8."""

    output = None

    def __init__(self, device: Device, mesh: TriangleMesh, params: Params) -> None:
        n = params.segments
        size = params.size_bytes
        if size is None:
            size = VERTEX_BYTES * mesh.triangle_count * (n + 1) * (n + 2) // 2
        self.setup = Timeline()
        self._device = device
        self._count = -(-size // VECTOR)
        with self.setup.host("allocate"):
            self._values = device.allocate("values", 8 * self._count, np.float32)
        self._kernel = None
        if params.by != "driver":
            with self.setup.host("build"):
                self._kernel = sweep(
                    device, "fill", self._count,
                    streaming=params.by == "streaming", values=self._values, value=VALUE,
                )  # fmt: skip
        with self.setup.host("first_launch"):
            self.enqueue(Frame(), Timeline())
            device.wait()

    def enqueue(self, frame: Frame, timeline: Timeline) -> None:
        """Fill the buffer once."""
        if self._kernel is not None:
            self._kernel(timeline)
        elif self._count:
            self._device.fill(timeline, "fill", self._values, VALUE)

    def result(self) -> Sequence[TriangleMesh]:
        """No mesh: bytes alone."""
        return ()

    def check(self) -> Check:
        """How many words hold another value."""
        wrong = int(np.count_nonzero(self._device.read(self._values) != VALUE))
        return Check(wrong == 0, "words that were not filled", wrong, 0)

    def counters(self) -> Mapping[str, int | float]:
        """`bytes` filled."""
        return {"bytes": VECTOR * self._count}

    def footprint(self) -> Footprint:
        """The buffer."""
        return Footprint(output_bytes=VECTOR * self._count)

    def traffic(self) -> Mapping[str, Traffic]:
        """Every byte is written once."""
        return {"fill": Traffic(VECTOR * self._count)} if self._count else {}


SYSTEM = System[Params](
    name="device_fill",
    family="baselines",
    source="McCalpin 1995, STREAM: the store half of its copy",
    takes=(TriangleMesh,),
    prepare=DeviceFill,
    cases={"kernel": Params(), "driver": Params(by="driver"), "streaming": Params(by="streaming")},
    notes="a limit, not a competitor: it computes nothing",
)
