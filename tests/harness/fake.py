"""A host subject whose result, verdict and slowness a test chooses, and what `lodbench` needs to find it."""

import time
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.measure import limits
from lodbench.harness.plan import registry
from lodbench.harness.plan import table as tables
from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.plan.table import Column, Table, ratio_columns
from lodbench.harness.report import derive
from lodbench.kernels.opencl.device import DeviceError, Unsupported
from lodbench.kernels.system import Check, Footprint, System, Timeline, Traffic

TETRAHEDRON = TriangleMesh(
    np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
    np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]),
)
DATASETS = ("one", "two", "three")
_RATE = {"subject": "kernel", "unit": "B/s", "best": 1.0, "median": 1.0, "samples": [1.0]}
LIMITS = SimpleNamespace(
    device="d", size_bytes=1, fill=_RATE, copy=_RATE, multiply_add=_RATE, launch_wall=_RATE,
    launch_event=_RATE,
)  # fmt: skip


@dataclass(frozen=True)
class Params:
    size: int = 1
    seconds: float = 0.0
    outcome: str = "ok"  # or wrong, unsupported, missing, memory, crash, late crash

    def __post_init__(self):
        if self.size < 1:
            raise ValueError(f"size: expected at least 1, got {self.size}")


class Fake:
    output = ()

    def __init__(self, device, surface, params):
        self.params, self.mesh, self.frames = params, surface, 0
        self.setup = Timeline()
        with self.setup.host("build"):
            pass
        if params.outcome == "unsupported":
            raise Unsupported("needs wings, device has none")
        if params.outcome == "missing":
            raise ImportError("No module named 'wings'")
        if params.outcome == "memory":
            raise MemoryError("3 GB for corners")
        if params.outcome == "crash":
            raise DeviceError("a command failed")

    def enqueue(self, frame, timeline):
        self.frames += 1
        if self.params.outcome == "late crash" and self.frames > 4:
            raise DeviceError("a command failed")
        with timeline.host("call"):
            time.sleep(self.params.seconds)

    def result(self):
        return [self.mesh]

    def check(self):
        return Check(self.params.outcome != "wrong", "difference", 1.0, 0.5)

    def counters(self):
        return {"triangles": 4 * self.params.size, "vertices": 4}

    def footprint(self):
        return Footprint(stored_vertices=4, stored_bytes=48)

    def traffic(self):
        return {"call": Traffic(48)}


def make(name, **cases):
    return System(
        name=name,
        family="fakes",
        source="a test",
        takes=(TriangleMesh,),
        prepare=Fake,
        cases=cases or {"default": Params()},
        runs_on="host",
    )


SYSTEMS = {name: make(name) for name in ("fake", "other")}


def table(seconds=0.0, datasets=DATASETS):
    def groups(quick):
        return [
            Group(
                dataset,
                (
                    Subject("fake", {"seconds": seconds}),
                    Subject("other", {"seconds": seconds}),
                    Subject("other", {"outcome": "wrong"}, label="wrong"),
                ),
                {"cells": 8},
            )
            for dataset in datasets
        ]

    columns = (
        Column("dataset", "dataset"),
        Column("system", "system"),
        Column("triangles_out", "triangles out"),
        Column("wall_s", "median wall", "s"),
        *ratio_columns(["other"]),
    )
    return Table("fake_table", "A fake table", "nobody 1999", groups, columns, notes=("a note",))


def find(name):
    if name not in DATASETS:
        raise ValueError(f"dataset: expected one of {DATASETS}, got {name!r}")
    return SimpleNamespace(name=name, surface=TETRAHEDRON, standin=False, content="")


def install(patch=setattr, seconds=0.0):
    """Put the fakes in place of the registry, the catalogue, the tables, the limits, the pictures and the report."""
    made = table(seconds)
    patch(registry, "registry", lambda: registry.Registry(dict(SYSTEMS), {"gone": "no package"}))
    patch(catalogue, "find", find)
    patch(tables, "tables", lambda: {made.id: made})
    patch(limits, "measure", lambda device: LIMITS)
    patch(derive, "write_report", lambda folder: None)
    patch(derive, "draw_pictures", lambda folder, device: "")
    return made
