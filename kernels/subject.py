"""The base of every subject that runs on a device: memory by role, steps with what they must move, what came out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.opencl import Buffer, Device, Timeline
from lodbench.kernels.system import Check, DeviceSurface, Footprint, Frame, Stored, Traffic

Role = Literal["input", "pattern", "output", "scratch"]
Amount = int | Callable[[Any], int]
"""Bytes or operations: known beforehand, or asked of the subject after its frame; holding the subject itself would keep
its memory until the collector comes."""

WORD = 4  # bytes of a float32 or uint32
POINT = 3 * WORD  # bytes of a point, a normal, a triangle's indices


def _size(buffers: Iterable[Buffer]) -> int:
    """Bytes; an empty buffer has none, though a driver needs one of it."""
    return sum(buffer.size_bytes for buffer in buffers if 0 not in buffer.shape)


@dataclass(frozen=True)
class Step:
    """One command of a frame, the stage its seconds count towards, and the least that it must move and compute."""

    enqueue: Callable[[Timeline], Any]
    stage: str
    bytes: Amount = 0
    flops: Amount = 0


class DeviceSubject:
    """What `prepare` gives for a device; a system adds its set-up, its `check`, and `steps` where frames differ.

    A system allocates through it, each buffer with its role, and adds the steps of a frame, each with the bytes and
    operations that it cannot do without: `footprint` and `traffic` are sums over these. It sets `output`, and calls
    `warm_up` when all is ready.

    Attributes:
        device: where it runs.
        setup: seconds of set-up by stage.
        output: the last frame's surfaces; none where it leaves nothing on the device.
        frame: the last one; None before the first.
    """

    output: Sequence[DeviceSurface] = ()

    def __init__(self, device: Device, setup: Timeline | None = None) -> None:
        self.device = device
        self.setup = Timeline() if setup is None else setup
        self.frame: Frame | None = None
        self._bytes: Counter[str] = Counter()
        self._steps: list[Step] = []
        self._enqueued: Sequence[Step] = ()
        self._rows: list[tuple[int, int]] | None = None  # of the last frame, once they were read

    # memory

    def allocate(
        self, name: str, shape: int | tuple[int, ...], dtype: Any, role: Role = "scratch"
    ) -> Buffer:
        """`Device.allocate`, counted towards `role`."""
        (buffer,) = self.hold(role, self.device.allocate(name, shape, dtype))
        return buffer

    def upload(
        self,
        name: str,
        values: ArrayLike,
        dtype: Any = None,
        shape: tuple[int | None, ...] | None = None,
        role: Role = "input",
        lent: bool = False,
    ) -> Buffer:
        """`Device.upload`, counted towards `role`."""
        (buffer,) = self.hold(role, self.device.upload(name, values, dtype, shape, lent))
        return buffer

    def hold(self, role: Role, *buffers: Buffer) -> tuple[Buffer, ...]:
        """Count buffers that something else made towards `role`."""
        self._bytes[role] += _size(buffers)
        return buffers

    def release(self, role: Role, *buffers: Buffer) -> None:
        """Count them no more, where others take their place."""
        self._bytes[role] -= _size(buffers)

    @contextmanager
    def holding(self, role: Role) -> Iterator[None]:
        """Count all that stays of what is allocated inside, by whomever, towards `role`."""
        before = self.device.used_bytes
        yield
        self._bytes[role] += self.device.used_bytes - before

    # a frame

    def add(
        self,
        enqueue: Callable[[Timeline], Any],
        bytes: Amount = 0,
        flops: Amount = 0,
        stage: str | None = None,
    ) -> Step:
        """One more step of every frame; `stage` is the launch's own, unless it is given."""
        step = Step(enqueue, stage or enqueue.stage, bytes, flops)  # pyright: ignore[reportFunctionMemberAccess]
        self._steps.append(step)
        return step

    def fill(self, stage: str, buffer: Buffer, value: Any) -> Step:
        """One more step: the whole buffer filled with one value."""
        device = self.device
        return self.add(lambda timeline: device.fill(timeline, stage, buffer, value), stage=stage)

    def steps(self, frame: Frame) -> Sequence[Step]:
        """What this frame enqueues, in order: all that was added, in a system whose frames are alike."""
        return self._steps

    def enqueue(self, frame: Frame, timeline: Timeline) -> None:
        """Enqueue the frame's steps; never waits."""
        self._enqueued = self.steps(frame)
        self.frame, self._rows = frame, None
        for step in self._enqueued:
            step.enqueue(timeline)

    def warm_up(self) -> None:
        """Run one frame, so that the driver has compiled and loaded every kernel."""
        with self.setup.host("first_launch"):
            self.enqueue(Frame(), Timeline())
            self.device.wait()

    # afterwards; a frame is run where there was none

    def live(self) -> tuple[int, int]:
        """Vertices and triangles of all surfaces of the last frame."""
        rows = self.live_rows()
        return sum(vertices for vertices, _ in rows), sum(triangles for _, triangles in rows)

    def live_rows(self) -> list[tuple[int, int]]:
        """Vertices and triangles of each surface of the last frame."""
        if self.frame is None:
            self.enqueue(Frame(), Timeline())
        rows = self._rows
        if rows is None:
            counts = [surface.counts for surface in self.output if surface.counts is not None]
            found = iter(self.read_counts(counts))
            rows = []
            for surface in self.output:
                sizes = surface.vertex_count, surface.triangle_count
                vertices, triangles = sizes if surface.counts is None else map(int, next(found))
                rows.append((vertices, triangles))
            self._rows = rows
        return rows

    def read_counts(self, counts: Sequence[Buffer]) -> Sequence[NDArray[np.uint32]]:
        """The last frame's live vertices and triangles, (2,) of each surface that counts them."""
        return self.device.read_all(*((buffer, None) for buffer in counts))

    def result(self) -> Sequence[TriangleMesh]:
        """The last frame's surfaces, read back, a mesh each."""
        wanted: list[tuple[Buffer, int]] = []
        for surface, (vertices, triangles) in zip(self.output, self.live_rows(), strict=True):
            wanted += [(surface.positions, vertices), (surface.triangles, triangles)]
            if surface.normals is not None:
                wanted.append((surface.normals, vertices))
        arrays = iter([array.reshape(-1, 3) for array in self.device.read_all(*wanted)])
        return [
            TriangleMesh(
                next(arrays), next(arrays), None if surface.normals is None else next(arrays)
            )
            for surface in self.output
        ]

    def check(self) -> Check:
        """The last frame's output against the reference."""
        raise NotImplementedError(f"{type(self).__name__}.check: expected of every system")

    def counters(self) -> Mapping[str, int | float]:
        """Vertices and triangles of the last frame, and what `more_counters` adds."""
        vertices, triangles = self.live()
        return {"vertices": vertices, "triangles": triangles, **self.more_counters()}

    def more_counters(self) -> Mapping[str, int | float]:
        """What else the frame made, by name."""
        return {}

    def stored(self) -> Stored:
        """What stays in memory to draw the surface, and a static buffer of it: here both are the result itself."""
        vertices, triangles = self.live()
        normals = any(surface.normals is not None for surface in self.output)
        size = POINT * ((1 + normals) * vertices + triangles)
        return Stored(vertices, size, vertices, size)

    def footprint(self) -> Footprint:
        """Bytes by role, of all that was allocated through this subject."""
        held = {f"{role}_bytes": count for role, count in self._bytes.items()}
        return Footprint(**held, **vars(self.stored()))

    def traffic(self) -> Mapping[str, Traffic]:
        """Per stage of the last frame, the sums over its steps."""
        self.live()
        sums: dict[str, Traffic] = {}
        for step in self._enqueued:
            bytes, flops = (
                int(amount(self) if callable(amount) else amount)
                for amount in (step.bytes, step.flops)
            )
            if bytes or flops:
                sums[step.stage] = sums.get(step.stage, Traffic(0)) + Traffic(bytes, flops)
        return sums
