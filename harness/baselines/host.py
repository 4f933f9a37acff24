"""A subject on the host: one function that `enqueue` calls, seen through the same contract as a kernel."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from threadpoolctl import ThreadpoolController

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.system import Check, Footprint, Frame, System, Traffic

STAGE = "call"

_pools: ThreadpoolController | None = None
_threads: int | None = None


def find_pools() -> None:
    """Look for the BLAS and OpenMP pools that are loaded by now: some come with a later import."""
    global _pools, _threads
    _pools, _threads = ThreadpoolController(), None


def limit_threads(count: int) -> None:
    """Let the pools found use `count` threads each; cheap when nothing changes."""
    global _threads
    if _pools is not None and count != _threads:
        _pools.limit(limits=count)
        _threads = count


@dataclass
class HostPrepared:
    """A function of the frame, ready to be called any number of times.

    Attributes:
        device: the device it is compared with; it may use as many threads as that has compute units.
        call: (frame) -> output, the timed work, in whatever form the work ends.
        read: (output) -> the meshes, untimed; ValueError where the output is not a mesh.
        verdict: (meshes) -> was the output right?
        setup: seconds of what was done once, before `call`.
        input_bytes: what the subject holds of its input.
        count: (output) -> more counters by name, or None.
    """

    device: Device
    call: Callable[[Frame], Any]
    read: Callable[[Any], Sequence[TriangleMesh]]
    verdict: Callable[[Sequence[TriangleMesh]], Check]
    setup: Timeline = field(default_factory=Timeline)
    input_bytes: int = 0
    count: Callable[[Any], Mapping[str, int | float]] | None = None
    output: tuple[()] = ()
    _last: Any = field(default=None, repr=False)

    def __post_init__(self) -> None:
        find_pools()

    def enqueue(self, frame: Frame, timeline: Timeline) -> None:
        """Call the function; its wall seconds are the stage "call", and the frame's."""
        with timeline.untimed():
            limit_threads(self.device.facts.compute_units)
            self._last = None  # the last frame's memory is free before the next is made
        with timeline.host(STAGE):
            self._last = self.call(frame)

    def result(self) -> Sequence[TriangleMesh]:
        """The last frame's meshes; a frame is run first when there was none."""
        if self._last is None:
            self.enqueue(Frame(), Timeline())
        return self.read(self._last)

    def check(self) -> Check:
        """The verdict; an output that is no mesh at all fails with the reason."""
        try:
            meshes = self.result()
        except ValueError as error:
            return Check(False, f"not a mesh: {error}", float("nan"), 0.0)
        return self.verdict(meshes)

    def counters(self) -> Mapping[str, int | float]:
        """`vertices` and `triangles` of all meshes together, and what `count` adds."""
        meshes = self.result()
        found: dict[str, int | float] = {
            "vertices": sum(mesh.vertex_count for mesh in meshes),
            "triangles": sum(mesh.triangle_count for mesh in meshes),
        }
        return found | dict(self.count(self._last) if self.count else {})

    def footprint(self) -> Footprint:
        """Bytes of the input and of the meshes that came out; a peer's own scratch memory is not seen."""
        meshes = self.result()
        size = sum(mesh.positions.nbytes + mesh.triangles.nbytes for mesh in meshes)
        vertices = sum(mesh.vertex_count for mesh in meshes)
        return Footprint(
            input_bytes=self.input_bytes,
            output_bytes=size,
            stored_vertices=vertices,
            stored_bytes=size,
            static_vertices=vertices,
            static_bytes=size,
        )

    def traffic(self) -> Mapping[str, Traffic]:
        """Nothing: what a host subject moves is not known."""
        return {}


def host_system(
    name: str,
    source: str,
    prepare: Callable[[Device, Any, Any], Any],
    cases: Mapping[str, Any],
    takes: tuple[type, ...] = (TriangleMesh,),
    notes: str = "",
) -> System[Any]:
    """A baseline that runs on the host, by what `prepare` gives: see `System` for the arguments."""
    return System(name, "baselines", source, takes, prepare, cases, runs_on="host", notes=notes)
