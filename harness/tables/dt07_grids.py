"""The grids of DeCoro & Tatarchuk's slides: bunny, dragon and buddha, quadrics against averages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.plan.table import (
    QUALITY_COLUMNS,
    STATUS_COLUMNS,
    WALL_COLUMNS,
    Column,
    Entry,
    Table,
    brief,
)

QUADRIC, AVERAGE, VERTICES = "quadric", "average", "vertex_average"
GRIDS: Mapping[str, tuple[tuple[int, int, int], ...]] = {
    "buddha_100k": ((45, 130, 45), (20, 70, 20), (10, 40, 10)),
    "bunny_closed_70k": ((90, 90, 90), (60, 60, 60), (20, 20, 20), (9, 9, 9)),
    "dragon_100k": ((100, 60, 20), (50, 25, 10), (30, 15, 6)),
}


def _group(dataset: str, cells: tuple[int, int, int]) -> Group:
    size = {"cells": cells}
    subjects = (
        Subject("quadric_clustering", size, QUADRIC),
        Subject("quadric_clustering", {**size, "placement": "paper"}, "paper"),
        Subject("quadric_clustering", {**size, "placement": "average"}, AVERAGE),
        Subject("vertex_average", size, VERTICES),
    )
    facts = {"grid": " x ".join(map(str, cells))}
    return Group(dataset, subjects, facts, quality=True, weight=1.5, standin_ok=True)


def groups(quick: bool) -> list[Group]:
    """Every grid of the slides; `quick` has the second of each model."""
    return [
        _group(dataset, cells)
        for dataset, grids in GRIDS.items()
        for cells in (grids[1:2] if quick else grids)
    ]


def own(entry: Entry) -> Mapping[str, Any]:
    """The error as a share of that of averages on the same grid."""
    other = entry.group.subjects.get(VERTICES)
    quality, theirs = entry.subject.quality or {}, (other.quality or {}) if other else {}
    if quality.get("rms_error") is None or not theirs.get("rms_error"):
        return {}
    return {"rms_error_share": quality["rms_error"] / theirs["rms_error"]}


TABLE = Table(
    id="dt07_grids",
    title="The grids of the slides, quadrics against averages",
    source="DeCoro & Tatarchuk 2007, slides 20 to 22, which show pictures: triangles and errors were not published",
    groups=groups,
    own=own,
    columns=(
        Column("dataset", "dataset", brief=True),
        Column("grid", "grid", brief=True),
        Column("system", "placement", brief=True),
        Column("triangles_in", "triangles in"),
        Column("triangles_out", "triangles out", brief=True),
        Column("vertices_out", "points out"),
        *QUALITY_COLUMNS,
        Column("rms_error_share", "RMS error as a share of vertex_average's", "1", brief=True),
        *brief(WALL_COLUMNS, "wall_s"),
        *STATUS_COLUMNS,
    ),
    notes=(
        "quadric is the regularised solve; paper the slides' own, which takes the average wherever det(A) is at most "
        "1e-11 in a unit box; average the mean of the triangles' corners; vertex_average that of the vertices.",
        "The same grid gives the same triangles, whatever the placement: only the vertices move. The bunny is closed "
        "here; the 9 x 9 x 9 grid is that of the slides' drawing.",
    ),
)
