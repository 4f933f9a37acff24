"""Multiresolution drawing of a geometry image against its rivals: Wang et al., table 1."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from lodbench.harness.group import Context, Group, Subject
from lodbench.harness.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.tables import (
    QUALITY_COLUMNS,
    WALL_COLUMNS,
    Column,
    Row,
    Table,
    measured,
    ratio_columns,
    ratios,
)
from lodbench.harness.timing import summary
from lodbench.kernels.cluster.quadric_clustering.search import find_cells
from lodbench.kernels.cluster.quadric_clustering.upload import Upload

DATASET = "bunny_closed_70k"
LEVEL = 8
OURS = "quadtree_lod"
BASELINES = ("serial_traversal", "numpy_quadtree_lod", "one_core", "full_image")
STAGES = ("filter", "mark", "vertex", "count", "scan", "emit")

# triangles: (this method, the paper's other column) in s; i5-4200H 2.8 GHz, GeForce GTX 850M
PUBLISHED_S = {
    69_444: (0.006, 0.017),
    52_017: (0.005, 0.009),
    34_627: (0.003, 0.005),
    17_240: (0.002, 0.002),
}


def same_threshold(context: Context) -> dict[str, Any]:
    """The threshold that gave ours its triangles."""
    return {"n": LEVEL, "threshold": context.counters[OURS]["threshold"]}


def same_count(context: Context) -> dict[str, Any]:
    """As many triangles as ours has."""
    return {"target_count": int(context.counters[OURS]["triangles"])}


def same_count_image(context: Context) -> dict[str, Any]:
    """The largest even grid with at most as many triangles, from the same image."""
    return {"n": LEVEL, **same_count(context)}


def near_cells(context: Context) -> dict[str, Any]:
    """The grid whose cells leave about as many triangles, found by counting passes."""
    wanted = same_count(context)["target_count"]
    return {"cells": find_cells(Upload(context.device, context.surface), wanted).cells}


def groups(quick: bool) -> list[Group]:
    """One group per row of the paper's table, coarsest last; the same with `quick`."""
    made = []
    for count in PUBLISHED_S:
        size: dict[str, Any] = {"n": LEVEL, "target_count": count}
        subjects = (
            Subject(OURS, size),
            Subject(OURS, size, "one_core", one_core=True),
            Subject(OURS, {**size, "placement": "fitted", "measure": "share"}, "fitted"),
            Subject("serial_traversal", size),
            Subject("numpy_quadtree_lod", same_threshold),
            Subject("uniform_grid", {"n": LEVEL}, "full_image", case="full"),
            Subject("uniform_grid", same_count_image, case="full"),
            Subject("quadric_clustering", near_cells),
            Subject("fast_simplification", same_count),
        )
        facts = {"triangles_asked": count}
        made.append(Group(DATASET, subjects, facts, True, weight=8.0, standin_ok=True))
    return made


def _stages(subject: SubjectRecord) -> Row:
    """Median seconds of each stage of the one-pass filter, and of its choice and merge together."""
    found = {name: summary(subject.stage_s(name)) for name in STAGES if name in subject.stages}
    return {f"{name}_s": value.median for name, value in found.items() if value}


def _row(run: RunRecord, group: GroupRecord, label: str) -> Row:
    subject = group.subjects[label]
    row = measured(group, subject) | _stages(subject)
    row |= ratios(group, subject, BASELINES, run.environment["seed"])
    count = group.facts["triangles_asked"]
    mine, other = PUBLISHED_S[count]
    row["published_wall_s"] = {OURS: mine, "numpy_quadtree_lod": other}.get(label)
    row["vertices_out"] = subject.counters.get("vertices")
    row["nodes"] = subject.counters.get("nodes")
    uniform = measured(group, group.subjects["uniform_grid"])["rms_error"]
    if uniform and row["rms_error"]:
        row["error_of_uniform_grid"] = uniform / row["rms_error"]
    return row


def rows(run: RunRecord, records: Sequence[GroupRecord]) -> list[Row]:
    """One row per subject and triangle count, in the paper's order."""
    return [_row(run, group, label) for group in records for label in group.subjects]


TABLE = Table(
    id="w14_table1",
    title="Drawing a geometry image in as much detail as asked for",
    source="Wang, Liu, Feng & Li, table 1; published on an i5-4200H 2.8 GHz with a GeForce GTX 850M",
    groups=groups,
    rows=rows,
    columns=(
        Column("dataset", "dataset"),
        Column("triangles_asked", "triangles asked for"),
        Column("system", "system"),
        Column("triangles_out", "triangles"),
        Column("vertices_out", "vertices"),
        Column("nodes", "nodes drawn"),
        *WALL_COLUMNS,
        Column("stage_s", "device time", "s"),
        *(Column(f"{name}_s", name, "s") for name in STAGES),
        *ratio_columns(BASELINES),
        *QUALITY_COLUMNS,
        Column("error_of_uniform_grid", "uniform grid's RMS error over this", "1"),
        Column("stored_bytes", "stored", "B"),
        Column("published_wall_s", "published", "s"),
    ),
    brief=(
        "triangles_asked",
        "system",
        "triangles_out",
        "wall_s",
        "ratio_to_serial_traversal",
        "ratio_to_numpy_quadtree_lod",
        "rms_error",
        "error_of_uniform_grid",
        "published_wall_s",
        "status",
    ),
    notes=(
        "The published times include drawing, on a GPU; ours are the stages before the rasteriser, on this device.",
        "The paper's other column is a method that it calls both ray casting and geometry images of [13]; its time "
        "stands beside the walk on the host, whose role it has, and is no measurement of it.",
        "The paper's rows are 100, 75, 50 and 25 % of its bunny; the full image has 131,072 triangles here, and a "
        "threshold is searched that leaves the published counts.",
        "one_core: the same kernels on one compute unit. fitted: vertices fitted to the full image, errors as shares; "
        "the others' vertices lie on samples. full_image: all of the image stored and passed through. uniform_grid: "
        "the largest even grid with at most as many triangles as quadtree_lod.",
    ),
)
