"""The contract: what a system is, what preparing one gives, and how one frame is run and timed."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any, Generic, Protocol, TypeVar, cast, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.opencl import Buffer, Device, Timeline, Unsupported
from lodbench.kernels.result import Left, Result

__all__ = [
    "View", "Frame", "Check", "Footprint", "Traffic", "DeviceSurface", "Prepared", "System", "run",
    "Timeline", "Unsupported",
]  # fmt: skip

P = TypeVar("P")
NOTHING_TO_DRAW = "needs a surface on the device to draw, subject leaves none"


@dataclass(frozen=True, eq=False)
class View:
    """A camera.

    `eye` (3,) in model units, `world_to_clip` (4, 4) float64 (column vectors, z in -w..w), viewport in pixels.
    """

    eye: NDArray[np.float64]
    world_to_clip: NDArray[np.float64]
    width: int
    height: int


@dataclass(frozen=True)
class Frame:
    """What changes from frame to frame; never part of Params. A camera path is a sequence of these."""

    view: View | None = None
    time: float = 0.0  # s, for animated displacement


@dataclass(frozen=True)
class Check:
    """Was the output right? `value` is what was measured, in the unit that `what` names.

    `parts` are figures by name of which `value` is the worst, each in its own unit.
    """

    passed: bool
    what: str
    value: float
    tolerance: float
    parts: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Footprint:
    """Device bytes by role, and what a static vertex buffer of the same surface would hold."""

    input_bytes: int = 0
    pattern_bytes: int = 0
    output_bytes: int = 0
    scratch_bytes: int = 0
    batches: int = 1
    stored_vertices: int = 0
    stored_bytes: int = 0  # what must stay in memory to draw the surface: geometry in, not output
    static_vertices: int = 0
    static_bytes: int = 0


@dataclass(frozen=True)
class Stored:
    """The last four of a `Footprint`."""

    stored_vertices: int
    stored_bytes: int
    static_vertices: int
    static_bytes: int


@dataclass(frozen=True)
class Traffic:
    """What a stage must move and compute at the least: for the share of the device's limits."""

    bytes: int
    flops: int = 0

    def __add__(self, other: Traffic) -> Traffic:
        return Traffic(self.bytes + other.bytes, self.flops + other.flops)


@dataclass(frozen=True)
class DeviceSurface:
    """One surface of the last frame, on the device: sized by capacity, its live rows counted there.

    ```
    positions, normals   float [3 * vertex_count]     packed x y z; normals may be None
    triangles            uint  [3 * triangle_count]   explicit topology; or, with `instances` > 1, the topology of one
                                                      primitive: instance i adds i * instance_vertices to each index
    counts               uint  [2] on the device      live vertices, live triangles; None: all of them
    ```
    """

    positions: Buffer
    normals: Buffer | None
    triangles: Buffer
    vertex_count: int
    triangle_count: int
    instances: int = 1
    instance_vertices: int = 0
    counts: Buffer | None = None


class Prepared(Protocol):
    """Inputs uploaded, programs built, every launch shape warmed.

    A device subject neither allocates nor loops over elements on the host after this.
    """

    @property
    def setup(self) -> Timeline:
        """Build, first launch, upload ...: seconds each, and whether it came from a cache."""
        ...

    @property
    def output(self) -> Sequence[DeviceSurface]:
        """The last frame's surfaces, all of which are drawn; none for subjects that leave nothing on the device."""
        ...

    def enqueue(self, frame: Frame, timeline: Timeline) -> None:
        """All stages of one frame; never waits. Host and GL subjects do their work here."""
        ...

    def result(self) -> Sequence[TriangleMesh]:
        """The last frame's meshes, read back, untimed; several for a level chain."""
        ...

    def check(self) -> Check:
        """The last frame's output against the float64 reference, or a peer's against what it promises."""
        ...

    def counters(self) -> Mapping[str, int | float]:
        """Vertices, triangles, cells ...: what the frame made, by name."""
        ...

    def footprint(self) -> Footprint:
        """Memory by role."""
        ...

    def traffic(self) -> Mapping[str, Traffic]:
        """Per stage: bytes that must move and flops that must be done."""
        ...


@runtime_checkable
class Growing(Protocol):
    """A subject whose frames may need more room than it has: none that overflowed is counted."""

    def overflowed(self) -> bool:
        """Did the last frame need more room than there was? It wrote nothing past it."""
        ...

    def grow(self) -> None:
        """Make the room that the last frame needed.

        Raises:
            Unsupported: the device has no more.
        """
        ...


@runtime_checkable
class Remembering(Protocol):
    """A subject whose frames depend on those before them."""

    def reset(self) -> None:
        """Forget them: the next frame is the first of a path."""
        ...


@runtime_checkable
class Parametric(Protocol):
    """A subject whose surface has the same parameters in every frame, whatever its level of detail."""

    def at_parameters(self) -> NDArray[np.float32]:
        """Points of the last frame's triangles, (n, 3), at parameters that stay the same from frame to frame."""
        ...


@dataclass(frozen=True)
class System(Generic[P]):
    """A subject under test.

    Attributes:
        name: the folder's name.
        family: the parent folder's name.
        source: paper and section, or the package that is wrapped.
        takes: the surface types that `prepare` accepts.
        prepare: (device, surface, params) -> Prepared; raises `Unsupported` where the device cannot.
        cases: named parameter sets; the first is the default.
        verbs: what users ask for by name ("simplify"), and the call that does it: (device, surface, **options) ->
            Result, options being those of the Params and the verb's own.
        streams: simplifies a file in batches, (device, MeshFile, temporary file, rows of a batch, told, **options) ->
            Left; None where the system cannot.
        runs_on: "device" or "host" ("gl" for an OpenGL driver); host subjects have wall time only.
    """

    name: str
    family: str
    source: str
    takes: tuple[type, ...]
    prepare: Callable[[Device, Any, P], Prepared]
    cases: Mapping[str, P]
    verbs: Mapping[str, Callable[..., Result]] = field(default_factory=dict)
    streams: Callable[..., Left] | None = None
    runs_on: str = "device"
    notes: str = field(default="")


Draws = Callable[[Sequence[DeviceSurface], Frame, Timeline], None]
"""What draws the surfaces of a frame: see `stages.raster.Raster`."""


def run(
    device: Device,
    prepared: Prepared,
    frame: Frame = Frame(),
    raster: Draws | None = None,
    wait: Callable[[], Any] | None = None,
) -> Timeline:
    """One frame: enqueue, optional raster and shading, wait once; device seconds per stage and wall seconds.

    A frame that overflowed is not counted: its subject grows, runs once to warm what is new, and then again.

    `wait` is the one wait, of a caller that has something to read then; the device's own otherwise.

    Raises:
        Unsupported: the frame is to be drawn and left no surface on the device: it would be no whole frame. Or the
            device has no room for it.
    """
    timeline = _frame(device, prepared, frame, raster, wait)
    growing = cast(Growing, prepared) if _grows(type(prepared)) else None
    while growing is not None and growing.overflowed():
        growing.grow()
        _frame(device, prepared, frame, raster, wait)
        timeline = _frame(device, prepared, frame, raster, wait)
    return timeline


@cache
def _grows(kind: type) -> bool:
    """Is it a `Growing`? Asked of an object, that takes as long as a launch."""
    return issubclass(kind, Growing)


def _frame(
    device: Device,
    prepared: Prepared,
    frame: Frame,
    raster: Draws | None,
    wait: Callable[[], Any] | None,
) -> Timeline:
    timeline = Timeline()
    start = time.perf_counter()
    prepared.enqueue(frame, timeline)
    if raster is not None:
        if not prepared.output:
            device.wait()
            raise Unsupported(NOTHING_TO_DRAW)
        raster(prepared.output, frame, timeline)
    (wait or device.wait)()
    timeline.wall_s = time.perf_counter() - start - timeline.untimed_s
    return timeline.collect()
