"""The same work on every OpenCL driver for the processor that is installed: its time, and whether the bytes agree."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lodbench.harness.plan.group import Draw, Group, Subject
from lodbench.harness.plan.table import (
    FRAME_COLUMNS,
    STATUS_COLUMNS,
    WALL_COLUMNS,
    Column,
    Entry,
    Table,
    brief,
)
from lodbench.kernels.opencl import DeviceError, driver


def runtimes() -> dict[str, str]:
    """Label -> what `--device` takes, of each driver with a processor; PoCL first, as it is the default."""
    try:
        found = [
            platform
            for _, platform, _, handle in driver.list_devices()
            if handle.type & driver.opencl().device_type.CPU
        ]
    except DeviceError:
        return {}
    names = {name.replace("Portable Computing Language", "PoCL"): name for name in found}
    return dict(sorted(names.items(), key=lambda one: not one[0].startswith("PoCL")))


def _group(work: str, dataset: str, system: str, drawn: bool, **params: Any) -> Group:
    draw = Draw(apart=True) if drawn else None
    subjects = tuple(
        Subject(system, params, label, draw=draw, device=name) for label, name in runtimes().items()
    )
    facts = {"work": work}
    return Group(dataset, subjects or (Subject(system, params, draw=draw),), facts, same=True)


def groups(quick: bool) -> list[Group]:
    """A frame of each kind: sums in cells, priorities in rounds, curves evaluated; drawn where that is quick."""
    return [
        _group(
            "clustering", "icosphere_6" if quick else "icosphere_8", "quadric_clustering", True,
            target_reduction=0.9,
        ),
        _group(
            "edge collapse", "icosphere_5" if quick else "icosphere_6", "edge_collapse", False,
            target_reduction=0.9,
        ),
        _group("curved refinement", "icosphere_3", "pn_triangles", True, segments=16),
        _group("Bezier patches", "pot_32", "vst", True),
    ]  # fmt: skip


def own(entry: Entry) -> Mapping[str, Any]:
    """Whether result and picture have the bytes of the group's first subject that has any, and what it ran on."""
    mine = entry.subject.quality or {}
    others = [subject.quality or {} for subject in entry.group.subjects.values()]
    first = next((other for other in others if "digest" in other), {})
    return {
        "driver": entry.subject.driver,
        "same_bytes": mine["digest"] == first.get("digest") if "digest" in mine else None,
        "same_picture": mine["picture"] == first.get("picture") if "picture" in mine else None,
    }


TABLE = Table(
    id="devices",
    title="The same work on every OpenCL driver for this processor",
    source="none: kernels are to give the same bytes on every driver for processors",
    groups=groups,
    own=own,
    columns=(
        Column("work", "work", brief=True),
        Column("dataset", "dataset"),
        Column("system", "driver", brief=True),
        Column("driver", "version"),
        Column("triangles_out", "triangles out", brief=True),
        Column("same_bytes", "same bytes as the first", brief=True),
        Column("same_picture", "same picture", brief=True),
        *brief(WALL_COLUMNS, "wall_s"),
        Column("stage_s", "device time", "s"),
        Column("first_launch_s", "first launch", "s", brief=True),
        *brief(FRAME_COLUMNS, "frame_s"),
        *STATUS_COLUMNS,
    ),
    notes=(
        "Drivers are those that the loader finds: PoCL from pip, and where they are installed PoCL of the system and "
        "Intel's. `lodbench doctor` writes the driver file that Intel's package from pip lacks.",
        "The subjects take turns in one process, in which each driver keeps threads of its own.",
        "The first launch holds compiling: PoCL keeps compiled kernels on disk, Intel's compiles in each process.",
    ),
)
