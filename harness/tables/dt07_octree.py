"""Clustering on an octree against a uniform grid, and the published table. DeCoro & Tatarchuk 2007, slides 29-33."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lodbench.harness.plan.group import Context, Group, Subject
from lodbench.harness.plan.table import (
    QUALITY_COLUMNS,
    STATUS_COLUMNS,
    WALL_COLUMNS,
    Column,
    Entry,
    Table,
    brief,
    ratio_columns,
    stage_columns,
)

PARTS = ("fandisk", "mechpart_g3", "rocker_arm", "threeholes_g3")
SCANS = ("armadillo_86k", "bunny_69k", "beetle_open", "mountain_od")
QUICK = (*PARTS[:2], SCANS[-1])
REDUCTIONS = (0.9, 0.72)
SWEPT, TRIANGLES = "bunny_69k", 4000
LEVELS, STORAGES = (5, 6, 7, 8), (0.02, 0.08, 0.3)
PUBLISHED_STORAGE = 0.08
OURS, UNIFORM, PUBLISHED = "octree", "quadric_clustering", "probabilistic_octree"
CUBES, FARTHEST = "octree_cubes", "octree_maximum"
QUALITY, TABLE_SIZE = "error", "storage"
ERRORS = ("rms_error", "rms_error_back", "max_error")


def same_count(context: Context) -> dict[str, Any]:
    """At most as many triangles as the octree left."""
    return {"target_count": int(context.counter(OURS, "triangles"))}


def _errors(dataset: str, reduction: float) -> Group:
    asked = {"target_reduction": reduction}
    subjects = (
        Subject(OURS, {**asked, "levels": None}),
        Subject(UNIFORM, same_count),
        Subject(OURS, {**asked, "levels": None, "shape": "cubes"}, CUBES),
        Subject(OURS, {**asked, "levels": None, "rule": "maximum"}, FARTHEST),
    )
    facts = {"work": QUALITY, "reduction": reduction}
    return Group(dataset, subjects, facts, True, weight=3.0, standin_ok=True)


def _sweep(levels: int, storage: float, quick: bool) -> Group:
    size = {
        "target_count": TRIANGLES, "max_error": None, "levels": levels, "storage": storage,
    }  # fmt: skip
    subjects = [
        Subject(UNIFORM, {"target_count": TRIANGLES}),
        Subject(PUBLISHED, size),
        Subject(PUBLISHED, {**size, "search": "binary"}, "binary"),
        Subject(PUBLISHED, {**size, "construction": "randomised"}, "randomised"),
    ]
    facts = {"work": TABLE_SIZE, "levels": levels, "storage": storage}
    chosen = subjects[:2] if quick else subjects
    return Group(SWEPT, tuple(chosen), facts, weight=4.0, standin_ok=True)


def groups(quick: bool) -> list[Group]:
    """Errors at equal counts, parts with flat areas first, then tables; `quick` has fewer of each."""
    datasets, reductions = (QUICK, REDUCTIONS[:1]) if quick else ((*PARTS, *SCANS), REDUCTIONS)
    sizes = [(levels, PUBLISHED_STORAGE) for levels in (LEVELS[:2] if quick else LEVELS)]
    if not quick:
        sizes += [(7, storage) for storage in STORAGES if storage != PUBLISHED_STORAGE]
    return [
        *(_errors(dataset, reduction) for dataset in datasets for reduction in reductions),
        *(_sweep(levels, storage, quick) for levels, storage in sizes),
    ]


def own(entry: Entry) -> Mapping[str, Any]:
    """Errors as shares of the uniform grid's, what the table lost, and what slide 33 says."""
    subject, counters = entry.subject, entry.subject.counters
    uniform = entry.group.subjects.get(UNIFORM)
    theirs = (uniform.quality if uniform else None) or {}
    mine = subject.quality or {}
    more: dict[str, Any] = {
        f"{key}_share": mine[key] / theirs[key] if mine.get(key) and theirs.get(key) else None
        for key in ERRORS
    }
    walls = [s["wall_s"] for s in uniform.samples] if uniform else []
    if walls and entry.row.get("wall_s") and subject.system != UNIFORM:
        more["slowdown"] = entry.row["wall_s"] / sorted(walls)[len(walls) // 2]
    if subject.system == OURS:
        more |= {key: counters.get(key) for key in ("used_boxes", "border_edges")}
    if subject.system == PUBLISHED:
        shown = ("keys", "slots", "collisions", "collisions_predicted", "disagreement")
        more |= {key: counters.get(key) for key in shown}
        if entry.row.get("storage") == PUBLISHED_STORAGE:
            more |= {"published_collisions": 0.1, "published_slowdown": 1.2}
    elif subject.system == UNIFORM:
        more |= {"levels": None, "storage": None}
    return more


TABLE = Table(
    id="dt07_octree",
    title="Clustering on an octree against a uniform grid of as many triangles",
    source="DeCoro & Tatarchuk 2007, slides 29-33; published on an ATI GPU: a bunny of 4,000 triangles, a table of 8 % "
    "of the tree, under 10 % of collisions, 20 % slower than a grid",
    groups=groups,
    own=own,
    columns=(
        Column("work", "work"),
        Column("dataset", "dataset", brief=True),
        Column("triangles_in", "triangles in"),
        Column("system", "subject", brief=True),
        Column("levels", "levels", brief=True),
        Column("storage", "slots of the full tree", "1", brief=True),
        Column("triangles_out", "triangles", brief=True),
        *brief(WALL_COLUMNS, "wall_s"),
        *ratio_columns([UNIFORM], shown=()),
        *brief(QUALITY_COLUMNS, "rms_error"),
        Column("rms_error_share", "RMS error over the grid's", "1", brief=True),
        Column("rms_error_back_share", "RMS error back over the grid's", "1"),
        Column("max_error_share", "largest error over the grid's", "1", brief=True),
        Column("slowdown", "time over the grid's", "1", brief=True),
        Column("used_boxes", "vertices of boxes"),
        Column("border_edges", "border edges"),
        Column("nodes", "nodes"),
        Column("keys", "keys"),
        Column("slots", "slots"),
        Column("collisions", "collisions", "1", brief=True),
        Column("collisions_predicted", "collisions predicted", "1", brief=True),
        Column("published_collisions", "published collisions, at most", "1"),
        Column("published_slowdown", "published time over the grid's", "1"),
        Column("disagreement", "binary search unlike linear", "1"),
        *stage_columns(("tree", "pass_1", "pass_2", "boxes", "cut", "pass_3")),
        Column("memory_bytes", "memory", "B"),
        *STATUS_COLUMNS,
    ),
    notes=(
        "error: quadric_clustering is asked for as many triangles as the octree left. octree joins children of a cube "
        "to boxes where that costs less error, octree_cubes keeps to cubes as published; octree_maximum goes by the "
        "farthest plane. How fine the finest cells are and when to join was chosen on fandisk and mechpart_g3.",
        "storage: the table as published. Collisions are keys that share their slot, predicted for a uniform hash; a "
        "vertex whose node was lost goes to the node's parent. Which levels the published figures had is not said.",
        "The published table was filled by blending on a GPU. Here it is 14 additions and two maxima of 64 and 32 bits "
        "for each corner and level, atomics on a CPU, which take nearly all of the time.",
        "Border edges hold the cells of grids and octrees alike, but not those of the table as published.",
    ),
)
