"""What border edges do to clustering an open mesh: left to shrink as published, held by planes, or kept as they are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from lodbench.harness.plan.group import Context, Group, Subject
from lodbench.harness.plan.table import (
    BORDER_COLUMN,
    QUALITY_COLUMNS,
    STATUS_COLUMNS,
    WALL_COLUMNS,
    Column,
    Entry,
    Table,
    brief,
    ratio_columns,
)

SCANS = ("beetle_open", "mountain_od", "camelhead_open", "bunny_69k")
GENERATED = ("terrain_50k", "open_blob_100k")
REDUCTIONS = (0.9, 0.97)
OURS = "quadric_clustering"
PLAIN, HELD, KEPT, PEER = "none", "quadrics", "keep", "fast_simplification"


def _same_cells(border: str) -> Any:
    def params(context: Context) -> dict[str, Any]:
        """The grid that the clustering without borders found."""
        return {"cells": context.counter(PLAIN, "cells_along_longest"), "border": border}

    return params


def same_count(context: Context) -> dict[str, Any]:
    """Exactly as many triangles as the clustering without borders left."""
    return {"target_count": int(context.counter(PLAIN, "triangles"))}


def _group(dataset: str, reduction: float) -> Group:
    size = {"target_reduction": reduction}
    subjects = (
        Subject(OURS, {**size, "border": PLAIN}, PLAIN),
        Subject(OURS, _same_cells(HELD), HELD),
        Subject(OURS, {**size, "border": KEPT}, KEPT),
        Subject(PEER, same_count),
    )
    return Group(
        dataset, subjects, {"reduction": reduction}, quality=True, weight=2.0,
        standin_ok=dataset in SCANS,
    )  # fmt: skip


def groups(quick: bool) -> list[Group]:
    """Open scans, and generated sheets with a border; `quick` has two of them, at a tenth."""
    datasets = (SCANS[1], GENERATED[0]) if quick else (*SCANS, *GENERATED)
    reductions = REDUCTIONS[:1] if quick else REDUCTIONS
    return [_group(dataset, reduction) for reduction in reductions for dataset in datasets]


def own(entry: Entry) -> Mapping[str, Any]:
    """Border edges in, what finding them took, and errors as shares of those without."""
    subject = entry.subject
    quality = subject.quality or {}
    plain = entry.group.subjects.get(PLAIN)
    before = (plain.quality or {}) if plain else {}
    more: dict[str, Any] = {
        "border_edges": subject.counters.get("border_edges"),
        "borders_s": subject.phases.get("borders"),
    }
    for key in ("rms_error", "max_error"):
        if quality.get(key) is not None and before.get(key):
            more[f"{key}_share"] = quality[key] / before[key]
    return more


TABLE = Table(
    id="borders",
    title="Clustering open meshes: what becomes of their borders",
    source="ours: DeCoro & Tatarchuk 2007 say nothing of borders; the planes are those of Lindstrom & Turk 1998",
    groups=groups,
    own=own,
    columns=(
        Column("dataset", "dataset", brief=True),
        Column("reduction", "removed", "1", brief=True),
        Column("system", "border", brief=True),
        Column("triangles_in", "triangles in"),
        Column("border_edges", "border edges"),
        Column("triangles_out", "triangles out", brief=True),
        *QUALITY_COLUMNS,
        replace(BORDER_COLUMN, brief=True),
        Column("rms_error_share", "RMS error as a share of none's", "1", brief=True),
        Column("max_error_share", "largest error as a share of none's", "1", brief=True),
        *brief(WALL_COLUMNS, "wall_s"),
        Column("borders_s", "finding border edges, once", "s"),
        *ratio_columns([PLAIN], shown=()),
        *STATUS_COLUMNS,
    ),
    notes=(
        "none and quadrics have the same grid, and so the same triangles; keep gives every border vertex back as it "
        "was, which takes a coarser grid for the same number.",
        "Border edges are found once, in the set-up; on a closed mesh that is one look at its triangles. How heavy "
        "their planes are was chosen on beetle_open and mountain_od.",
        "How far the border draws back from corners is its largest move, a share of the diagonal; RMS errors hide it.",
    ),
)
