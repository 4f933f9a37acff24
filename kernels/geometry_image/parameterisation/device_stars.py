"""The star optimisation's colour pass on the device, in float64: the host's moves, several times faster."""

from __future__ import annotations

import numpy as np

from lodbench.kernels.geometry_image.parameterisation import stars
from lodbench.kernels.geometry_image.parameterisation.hierarchy import Points
from lodbench.kernels.opencl import Buffer, Device, Timeline

LOCAL_SIZE = (
    16  # vertices per group: coarse levels have few per colour, and every core should get some
)


class DeviceSweep:
    """`stars.sweep` on a device that has float64; see there for the arguments.

    The sphere is sent once for a batch of sweeps and fetched after it. Results do not depend on the work-group size.
    """

    def __init__(self, device: Device) -> None:
        self._device = device
        self._program = device.build(
            "geometry_image/parameterisation/setup.cl",
            defines={
                "DOWNHILL_TRIALS": stars.DOWNHILL_TRIALS,
                "RANDOM_TRIALS": stars.RANDOM_TRIALS,
                "DOWNHILL_FACTOR": stars.DOWNHILL_FACTOR,
                "STEP": stars.STEP,
                "INVERSE_STRETCH": stars.INVERSE_STRETCH,
            },
        )
        self._buffers: dict[str, Buffer] = {}

    @staticmethod
    def possible(device: Device) -> bool:
        return "cl_khr_fp64" in device.facts.extensions

    def _buffer(self, name: str, values: np.ndarray) -> Buffer:
        """A buffer holding `values`, kept and grown: hundreds of levels would each make their own."""
        held = self._buffers.get(name)
        if held is None or held.shape[0] < values.size:
            held = self._device.allocate(name, max(2 * values.size, 64), values.dtype)
            self._buffers[name] = held
        cl = self._device.cl
        flat = np.ascontiguousarray(values).reshape(-1)
        cl.enqueue_copy(self._device.queue, held.memory, flat, is_blocking=True)
        return held

    def __call__(self, sphere: Points, moved: stars.Stars, turn: int, sweeps: int = 1) -> None:
        on_device = self._buffer("sphere", sphere)
        launch = self._program.launch(
            "parameterisation_setup_star", 1, stage="sweep", local=LOCAL_SIZE,
            vertices=self._buffer("vertices", moved.vertices.astype(np.uint32)),
            starts=self._buffer("starts", moved.starts.astype(np.uint32)),
            after=self._buffer("after", moved.after.astype(np.uint32)),
            last=self._buffer("last", moved.last.astype(np.uint32)),
            rest=self._buffer("rest", moved.rest),
            sphere=on_device, turn=turn, first=0, count=0,
        )  # fmt: skip
        timeline = Timeline()
        for k in range(sweeps):
            for first, end in zip(moved.colours[:-1], moved.colours[1:], strict=True):
                launch.set(turn=turn + k, first=int(first), count=int(end - first))
                launch.items = int(end - first)
                launch(timeline)
        self._device.cl.enqueue_copy(
            self._device.queue, sphere.reshape(-1), on_device.memory, is_blocking=True
        )
