"""Quadric clustering on more cores than there are: every work-group timed alone, and the groups shared out on paper.

The frame is cut as a device of so many cores would cut it. Its launches run one work-group after the other on one core,
and `cores` that each take the next group as they come free would have ended a launch with its longest chain of groups;
the sum over launches is the projected time. What it leaves out: what a launch itself takes, and what cores cost each
other, such as the memory's bandwidth and the cache that they share. So it is optimistic, and no measurement.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.kernels.cluster.quadric_clustering import SYSTEM as QUADRIC_CLUSTERING
from lodbench.kernels.cluster.quadric_clustering import Params as Clustering
from lodbench.kernels.opencl import Device, Launch, Timeline
from lodbench.kernels.parameters import Range
from lodbench.kernels.subject import DeviceSubject
from lodbench.kernels.system import Frame

PASSES = 3  # of a frame: between others' frames the first one finds its data in no cache


@dataclass(frozen=True)
class Params(Clustering):
    """Those of quadric_clustering, and the machine that is not there.

    Attributes:
        cores: of the machine, 1 to 1024.
    """

    cores: Annotated[int, Range(1, 1024)] = 16


def longest_chain(seconds: Iterable[float], cores: int) -> float:
    """When the last of these is done where each of `cores` takes the next as it comes free."""
    free = [0.0] * cores
    for one in seconds:
        heapq.heappush(free, heapq.heappop(free) + one)
    return float(max(free))


class Projection:
    """One prepared frame, run group by group; keeps the least seconds of each group."""

    def __init__(self, device: Device, subject: DeviceSubject, cores: int) -> None:
        self.device, self.subject, self.cores = device, subject, cores
        self._steps = subject.steps(Frame())
        self._least: list[NDArray[np.float64]] = []

    def run(self) -> None:
        """Every group of every launch alone, in order; what the driver does by itself counts as one group."""
        self.subject.frame = Frame()
        events = []
        for step in self._steps:
            timelines = [Timeline() for _ in range(_groups(step.enqueue))]
            for group, timeline in enumerate(timelines):
                if isinstance(step.enqueue, Launch):
                    step.enqueue.group(timeline, group)
                else:
                    step.enqueue(timeline)
            events.append(timelines)
        self.device.wait()
        found = [np.array([t.collect().total_s for t in timelines]) for timelines in events]
        before = self._least or found
        self._least = [np.minimum(a, b) for a, b in zip(before, found, strict=True)]

    def counters(self) -> Mapping[str, int | float]:
        """Seconds of one core and of the longest chain, s, by stage too; launches, and those of a single group."""
        chains = [longest_chain(seconds, self.cores) for seconds in self._least]
        work = sum(float(seconds.sum()) for seconds in self._least)
        counters: dict[str, int | float] = {
            "work_s": work,
            "chain_s": sum(chains),
            "chain_share": sum(chains) / work if work else 0.0,
            "launches": len(chains),
            "serial_s": sum(float(s.sum()) for s in self._least if len(s) == 1),
        }
        for step, chain in zip(self._steps, chains, strict=True):
            key = f"chain_{step.stage}_s"
            counters[key] = counters.get(key, 0.0) + chain
        return counters


def _groups(enqueue: Any) -> int:
    return enqueue.groups if isinstance(enqueue, Launch) else 1


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> HostPrepared:
    """The frame as a device of `cores` cuts it, on this one."""
    wide = Device(device.handle, memory_limit=device.memory_limit, local_size=device.local_size)
    wide.facts = replace(wide.facts, compute_units=params.cores)
    subject = QUADRIC_CLUSTERING.prepare(wide, mesh, params)
    assert isinstance(subject, DeviceSubject)
    projection = Projection(wide, subject, params.cores)

    def call(_: Frame) -> Projection:
        for _pass in range(PASSES):
            projection.run()
        return projection

    def read(_: Projection) -> Sequence[TriangleMesh]:
        return subject.result()

    return HostPrepared(
        device,
        call,
        read=read,
        verdict=lambda _: subject.check(),
        setup=subject.setup,
        input_bytes=mesh.positions.nbytes + mesh.triangles.nbytes,
        count=lambda done: {**subject.more_counters(), **done.counters()},
    )


SYSTEM = host_system(
    "projected_cores",
    "quadric_clustering, every work-group timed alone; a projection",
    prepare,
    {
        "cells_64": Params(64),
        "slabs_64": Params(64, accumulate="slabs", cores=64),
    },
    notes="its time is that of the groups one after the other; the projection is chain_s",
)
