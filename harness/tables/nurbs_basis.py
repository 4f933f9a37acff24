"""Ways to evaluate basis functions by degree: Concheiro 2013, section 6.5."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.plan.table import (
    STATUS_COLUMNS,
    Column,
    Entry,
    Row,
    Table,
    interval_columns,
)
from lodbench.harness.report.ratios import counts, interval
from lodbench.harness.report.statistics import paired_ratio

DEGREES = range(1, 8)
ONLY_QUICK = (3, 5)
LEVEL = 6
STAGE = "basis"
STAIR, OTHERS = "stair", ("cox_de_boor", "triangle")


def _group(degree: int) -> Group:
    subjects = tuple(
        Subject("uniform_nurbs", {"level": LEVEL, "basis": basis, "normals": False}, basis)
        for basis in (STAIR, *OTHERS)
    )
    return Group(f"sheets_degree_{degree}", subjects, {"degree": degree}, warm=True)


def groups(quick: bool) -> list[Group]:
    """Each degree; `quick` has two."""
    return [_group(degree) for degree in (ONLY_QUICK if quick else DEGREES)]


def own(entry: Entry) -> Mapping[str, Any]:
    """Of the stage alone: seconds for each sample of a side, and how many times faster it is than the others'."""
    ours, samples = entry.subject, entry.subject.counters.get("side_samples")
    seconds = entry.row.get(f"{STAGE}_s")
    more: Row = {"ns_per_sample": 1e9 * seconds / samples if seconds and samples else None}
    for name in OTHERS:
        theirs = entry.group.subjects.get(name)
        ratio = None
        if theirs is not None and theirs is not ours and counts(ours) and counts(theirs):
            ratio = paired_ratio(theirs.stage_by_turn(STAGE), ours.stage_by_turn(STAGE))
        more |= interval(f"basis_ratio_to_{name}", ratio)
    return more


TABLE = Table(
    id="nurbs_basis",
    title="Ways to evaluate basis functions",
    source="Concheiro 2013, section 6.5 (stair strategy), whose values were not at hand",
    groups=groups,
    own=own,
    columns=(
        Column("degree", "degree", brief=True),
        Column("system", "basis functions", brief=True),
        Column(f"{STAGE}_s", "basis functions", "s", brief=True),
        Column("side_samples", "samples"),
        Column("ns_per_sample", "ns per sample", "1", brief=True),
        *(
            column
            for name in OTHERS
            for column in interval_columns(
                f"basis_ratio_to_{name}", f"times faster than {name}", f"than {name}, "
            )
        ),
        Column("wall_s", "median wall", "s", brief=True),
        Column("samples", "n"),
        *STATUS_COLUMNS,
    ),
    notes=(
        "256 surfaces of one degree in both directions, inner knots uneven and one of them repeated as often as the "
        "degree. Ratios are of the stage that evaluates all basis functions at all samples of rows and columns, by the "
        "device's clock: points are the same for all three, and take most of a frame.",
        "stair: sums of products, 2^p of them, their beginnings shared. triangle: the triangular table, p (p + 1) / 2 "
        "cells. cox_de_boor: the recursion's cells for each function by itself, with its tests for 0 / 0.",
        "Every sample follows at once on frames of the same subject that are not timed.",
    ),
)
