"""Multiresolution drawing of a geometry image against its rivals: Wang et al., table 1."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lodbench.datasets_gen import catalogue
from lodbench.harness.plan.group import Context, Draw, Group, Subject
from lodbench.harness.plan.table import (
    FRAME_COLUMNS,
    QUALITY_COLUMNS,
    WALL_COLUMNS,
    Column,
    Entry,
    Row,
    Table,
    brief,
    ratio_columns,
    stage_columns,
)
from lodbench.harness.record.record import GroupRecord
from lodbench.harness.report.rows import published

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
    return {"n": LEVEL, "threshold": context.counter(OURS, "threshold")}


def same_count(context: Context) -> dict[str, Any]:
    """As many triangles as ours has."""
    return {"target_count": int(context.counter(OURS, "triangles"))}


def same_count_image(context: Context) -> dict[str, Any]:
    """The largest even grid with at most as many triangles, from the same image."""
    return {"n": LEVEL, **same_count(context)}


def groups(quick: bool) -> list[Group]:
    """One group per row of the paper's table, coarsest last, then of a second scan; `quick`: half of the paper's."""
    asked = {DATASET: tuple(PUBLISHED_S)[:: 2 if quick else 1]}
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
        Subject("quadric_clustering", same_count, draw=DRAW),
        Subject("fast_simplification", same_count),
    )


def own(entry: Entry) -> Mapping[str, Any]:
    """The error beside the uniform grid's, and the published time."""
    more: Row = {}
    asked = entry.group.facts["triangles_asked"]
    if entry.subject.label == OURS and asked in PUBLISHED_S:
        more["published_wall_s"], _ = PUBLISHED_S[asked]
    uniform = (entry.group.subjects["uniform_grid"].quality or {}).get("rms_error")
    if uniform and entry.row["rms_error"]:
        more["error_of_uniform_grid"] = uniform / entry.row["rms_error"]
    return more


def also(group: GroupRecord) -> list[Row]:
    """What the paper compares itself with: nothing of it was measured."""
    asked = group.facts["triangles_asked"]
    if asked not in PUBLISHED_S:
        return []
    _, other = PUBLISHED_S[asked]
    return [published(group, PREDECESSOR, published_wall_s=other)]


TABLE = Table(
    id="w14_table1",
    title="Drawing a geometry image in as much detail as asked for",
    source="Wang, Liu, Feng & Li, table 1; published on an i5-4200H 2.8 GHz with a GeForce GTX 850M",
    groups=groups,
    own=own,
    also=also,
    any_count=("full_image",),
    columns=(
        Column("dataset", "dataset", brief=True),
        Column("triangles_asked", "triangles asked for", brief=True),
        Column("system", "system", brief=True),
        Column("triangles_out", "triangles", brief=True),
        Column("vertices_out", "vertices"),
        Column("nodes", "nodes drawn"),
        *WALL_COLUMNS,
        Column("stage_s", "device time", "s"),
        *brief(FRAME_COLUMNS, "frame_s"),
        *stage_columns(STAGES),
        *ratio_columns(BASELINES, shown=BASELINES[:2]),
        *brief(QUALITY_COLUMNS, "rms_error"),
        Column("error_of_uniform_grid", "uniform grid's RMS error over this", "1", brief=True),
        Column("stored_bytes", "stored", "B"),
        Column("published_wall_s", "published", "s", brief=True),
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
