"""Multiresolution drawing of a geometry image against its rivals: Wang et al., table 1."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from lodbench.datasets_gen import catalogue
from lodbench.harness.group import Context, Draw, Group, Subject
from lodbench.harness.ratios import ratios
from lodbench.harness.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.tables import (
    FRAME_COLUMNS,
    QUALITY_COLUMNS,
    WALL_COLUMNS,
    Column,
    Row,
    Table,
    measured,
    published,
    ratio_columns,
)
from lodbench.harness.timing import summary
from lodbench.kernels.cluster.prepare import search_cells
from lodbench.kernels.cluster.upload import Upload

DATASET = "bunny_closed_70k"
SECOND = {"armadillo_86k": (86_482, 64_861, 43_241, 21_620)}  # 100, 75, 50, 25 % of its triangles
LEVEL = 8
DRAW = Draw(apart=True)
OURS = "quadtree_lod"
PREDECESSOR = "paper's predecessor"
BASELINES = ("serial_traversal", "numpy_quadtree_lod", "one_core", "full_image")
STAGES = ("filter", "mark", "vertex", "count", "scan", "emit")

# triangles: (this method, the paper's other column) in s; on an
# i5-4200H 2.8 GHz with a GeForce GTX 850M
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
    return {"cells": search_cells(Upload(context.device, context.surface), wanted).cells}


def groups(quick: bool) -> list[Group]:
    """One group per row of the paper's table, coarsest last, then of a second scan; `quick`: only the paper's."""
    asked = {DATASET: tuple(PUBLISHED_S)}
    if not quick:
        asked |= {name: SECOND[name] for name in SECOND if name in catalogue.names()}
    made = []
    for dataset, counts in asked.items():
        for count in counts:
            facts = {"triangles_asked": count}
            subjects = _subjects(count)
            made.append(Group(dataset, subjects, facts, True, weight=8.0, standin_ok=True))
    return made


def _subjects(count: int) -> tuple[Subject, ...]:
    # without a view, drawn or not: the count decides
    size: dict[str, Any] = {"n": LEVEL, "target_count": count, "view": "none"}
    fitted = {**size, "placement": "fitted", "error_metric": "rms_share"}
    return (
        Subject(OURS, size, draw=DRAW),
        Subject(OURS, size, "one_core", one_core=True),
        Subject(OURS, fitted, "fitted", draw=DRAW),
        Subject("serial_traversal", size, draw=DRAW),
        Subject("numpy_quadtree_lod", same_threshold),
        Subject("uniform_grid", {"n": LEVEL}, "full_image", case="full", draw=DRAW),
        Subject("uniform_grid", same_count_image, case="full", draw=DRAW),
        Subject("quadric_clustering", near_cells, draw=DRAW),
        Subject("fast_simplification", same_count),
    )


def _stages(subject: SubjectRecord) -> Row:
    """Median seconds of each stage of the one-pass filter, and of its choice and merge together."""
    found = {name: summary(subject.stage_s(name)) for name in STAGES if name in subject.stages}
    return {f"{name}_s": value.median for name, value in found.items() if value}


def _row(run: RunRecord, group: GroupRecord, label: str) -> Row:
    subject = group.subjects[label]
    row = measured(group, subject) | _stages(subject)
    row |= ratios(group, subject, BASELINES, run.environment["seed"], any_count=("full_image",))
    if label == OURS and group.facts["triangles_asked"] in PUBLISHED_S:
        row["published_wall_s"], _ = PUBLISHED_S[group.facts["triangles_asked"]]
    row["vertices_out"] = subject.counters.get("vertices")
    row["nodes"] = subject.counters.get("nodes")
    uniform = measured(group, group.subjects["uniform_grid"])["rms_error"]
    if uniform and row["rms_error"]:
        row["error_of_uniform_grid"] = uniform / row["rms_error"]
    return row


def rows(run: RunRecord, records: Sequence[GroupRecord]) -> list[Row]:
    """One row per subject and triangle count, in the paper's order, and one for what it compares itself with."""
    found = []
    for group in records:
        found += [_row(run, group, label) for label in group.subjects]
        if group.facts["triangles_asked"] in PUBLISHED_S:
            _, other = PUBLISHED_S[group.facts["triangles_asked"]]
            found.append(published(group, PREDECESSOR, published_wall_s=other))
    return found


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
        *FRAME_COLUMNS,
        *(Column(f"{name}_s", name, "s") for name in STAGES),
        *ratio_columns(BASELINES),
        *QUALITY_COLUMNS,
        Column("error_of_uniform_grid", "uniform grid's RMS error over this", "1"),
        Column("stored_bytes", "stored", "B"),
        Column("published_wall_s", "published", "s"),
    ),
    brief=(
        "dataset",
        "triangles_asked",
        "system",
        "triangles_out",
        "wall_s",
        "frame_s",
        "ratio_to_serial_traversal",
        "ratio_to_numpy_quadtree_lod",
        "rms_error",
        "error_of_uniform_grid",
        "published_wall_s",
        "status",
    ),
    notes=(
        "The published times include drawing, on a GPU; ours are the stages before the rasteriser, on this device. The "
        "frame adds raster and shading at 1280 x 1024, the whole surface in view, in turns of its own after samples.",
        "The paper's other column is a method that it calls both ray casting and geometry images of [13]: a row of "
        "its own, of which nothing was measured. The walk on the host, numpy_quadtree_lod, has its role here.",
        "The paper's rows are 100, 75, 50 and 25 % of its bunny; the full image has 131,072 triangles here, and a "
        "threshold is searched that leaves the published counts. The same shares of the armadillo are no rows of the "
        "paper.",
        "one_core: the same kernels on one compute unit. fitted: vertices fitted to the full image, errors as shares; "
        "the others' vertices lie on samples. full_image: all of the image stored and passed through, "
        "the one ratio between unlike counts. uniform_grid: the largest even grid with at most "
        "as many triangles as quadtree_lod.",
    ),
)
