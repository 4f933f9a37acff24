"""As many bytes as a tessellated surface has, filled with one value: nothing that writes them can be faster.

Interleaved with a subject in a table, it shows what share of the device's writing speed that subject reaches.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from lodbench.datasets_gen.nurbs_surface import NurbsModel
from lodbench.datasets_gen.surfaces import BezierPatches, TriangleMesh
from lodbench.harness.measure.limits import VECTOR, sweep
from lodbench.kernels.opencl import Device, Unsupported
from lodbench.kernels.parameters import Parameters, Range
from lodbench.kernels.refine.lattice import Segments
from lodbench.kernels.subject import DeviceSubject
from lodbench.kernels.system import Check, System

__all__ = ["SYSTEM", "DeviceFill", "Params"]

VALUE = 1.0
VERTEX_BYTES = 24  # a position and a normal of packed floats


@dataclass(frozen=True)
class Params(Parameters):
    """How much is filled, and by what.

    Attributes:
        size_bytes: bytes to fill; None, for a mesh alone: the positions and normals of the mesh with every triangle
            refined to `segments` per edge, 24 * (n + 1)(n + 2) / 2 bytes per triangle.
        segments: segments per edge, at least 1; only for `size_bytes` None.
        by: "driver" the driver's fill command, "kernel" a vector kernel, "streaming" the same with stores that bypass
            the caches.
    """

    size_bytes: Annotated[int, Range(0)] | None = None
    segments: Segments = 16
    by: Literal["driver", "kernel", "streaming"] = "kernel"


class DeviceFill(DeviceSubject):
    """One fill of one buffer per frame; its size is rounded up to a whole float8."""

    def __init__(
        self, device: Device, surface: TriangleMesh | BezierPatches | NurbsModel, params: Params
    ) -> None:
        super().__init__(device)
        n = params.segments
        size = params.size_bytes
        if size is None:
            if not isinstance(surface, TriangleMesh):
                kind = type(surface).__name__
                raise Unsupported(f"size_bytes: needs a number for {kind}, got None")
            size = VERTEX_BYTES * surface.triangle_count * (n + 1) * (n + 2) // 2
        count = -(-size // VECTOR)
        self._size = VECTOR * count
        with self.setup.host("allocate"):
            values = self._values = self.allocate("values", 8 * count, np.float32, "output")
        if params.by == "driver":
            self.add(lambda t: device.fill(t, "fill", values, VALUE), self._size, stage="fill")
        else:
            streaming = params.by == "streaming"
            with self.setup.host("build"):
                kernel = sweep(
                    device, "fill", count, streaming=streaming, values=values, value=VALUE
                )
            self.add(kernel, self._size)
        self.warm_up()

    def result(self) -> Sequence[TriangleMesh]:
        """No mesh: bytes alone."""
        return ()

    def check(self) -> Check:
        """How many words hold another value."""
        wrong = int(np.count_nonzero(self.device.read(self._values) != VALUE))
        return Check(wrong == 0, "words that were not filled", wrong, 0)

    def counters(self) -> Mapping[str, int | float]:
        """`bytes` filled."""
        return {"bytes": self._size}


SYSTEM = System[Params](
    name="device_fill",
    family="baselines",
    source="McCalpin 1995, STREAM: the store half of its copy",
    takes=(TriangleMesh, BezierPatches, NurbsModel),
    prepare=DeviceFill,
    cases={"kernel": Params(), "driver": Params(by="driver"), "streaming": Params(by="streaming")},
    notes="a limit, not a competitor: it computes nothing",
)
