"""What further levels of detail cost once the first is there: DeCoro & Tatarchuk 2007, alternate pass 2."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from lodbench.harness.plan.group import Context, Group, Subject
from lodbench.harness.plan.table import (
    QUALITY_COLUMNS,
    WALL_COLUMNS,
    Column,
    Entry,
    Row,
    Table,
    brief,
    interval_columns,
)
from lodbench.harness.record.record import GroupRecord, SubjectRecord
from lodbench.harness.report.ratios import counts, interval
from lodbench.harness.report.statistics import paired_ratio
from lodbench.harness.tables.dt07_timing import REDUCTION, SCANS, SERIES, SORTED

LEVELS = (2, 3, 4)
CHAIN, AGAIN = "level_chain", "quadric_clustering"
FIRST = "level_1"
GENERATED = (SORTED, SERIES[1])
QUICK_GENERATED = ("displaced_icosphere_330k_sorted",)


def up_to(level: int) -> str:
    """The label of a chain that ends at a level."""
    return f"level_{level}"


def anew(level: int) -> str:
    """The label of the mesh itself clustered on a level's grid."""
    return f"anew_{level}"


def chained(level: int) -> Callable[[Context], dict[str, Any]]:
    """The first level's grid and so many levels."""

    def same_grid(context: Context) -> dict[str, Any]:
        return {"cells": context.counter(FIRST, "cells_along_longest"), "levels": level}

    return same_grid


def halved(level: int) -> Callable[[Context], dict[str, Any]]:
    """The grid of a level."""

    def coarser(context: Context) -> dict[str, Any]:
        return {"cells": max(context.counter(FIRST, "cells_along_longest") / 2 ** (level - 1), 1.0)}

    return coarser


def groups(quick: bool) -> list[Group]:
    """Scans (or their stand-ins), then a generated surface in two triangle orders; `quick`: two, and a smaller one."""
    subjects = (
        Subject(CHAIN, {"target_reduction": REDUCTION, "levels": 1}, FIRST),
        *(Subject(CHAIN, chained(level), up_to(level)) for level in LEVELS),
        *(Subject(AGAIN, halved(level), anew(level)) for level in LEVELS),
    )
    return [
        Group(
            name, subjects, {"reduction": REDUCTION}, True,
            weight=8.0 if name in GENERATED else 3.0, standin_ok=name in SCANS,
        )
        for name in ((*SCANS[:2], *QUICK_GENERATED) if quick else (*SCANS, *GENERATED))
    ]  # fmt: skip


def _device_s(subject: SubjectRecord, *stages: str) -> dict[int, float]:
    """Turn -> seconds of these stages, of all where none is named."""
    turns = (row["turn"] for row in subject.samples)
    return dict(zip(turns, subject.stage_s(*stages), strict=True))


def _compared(group: GroupRecord, level: int, seed: int) -> Row:
    """A chain up to `level` against the first level alone, and against each of its levels clustered anew."""
    chain, others = group.subjects[up_to(level)], [group.subjects.get(FIRST)]
    others += [group.subjects.get(anew(number)) for number in range(2, level + 1)]
    if not counts(chain) or not all(map(counts, others)):
        return {}
    first, *again = (subject for subject in others if subject is not None)
    share = interval("share", paired_ratio(chain.wall_s, first.wall_s, seed))
    row: Row = {key: None if value is None else value - 1 for key, value in share.items()}
    turns = set(first.wall_s).intersection(*(subject.wall_s for subject in again))
    whole = {turn: sum(one.wall_s[turn] for one in (first, *again)) for turn in turns}
    row |= interval("chain_ratio", paired_ratio(whole, chain.wall_s, seed))
    own = {turn: s for turn, s in _device_s(chain, up_to(level)).items() if s > 0}
    return row | interval("level_ratio", paired_ratio(_device_s(again[-1]), own, seed))


def own(entry: Entry) -> Mapping[str, Any]:
    """The level that a row stands for, what came out of it, and what it cost beside the first and done anew."""
    subject, counters = entry.subject, entry.subject.counters
    level = int(subject.label.rpartition("_")[2])
    more: Row = {"level": level, "level_s": None}
    if subject.system != CHAIN or level == 1 or not counters:
        return more
    more |= {
        "triangles_out": counters.get(f"level_{level}_triangles"),
        "vertices_out": counters.get(f"level_{level}_vertices"),
        # what was judged is the first level, each time the same
        **{column.key: None for column in QUALITY_COLUMNS},
    }
    seconds = subject.stage_s(up_to(level))
    more["level_s"] = float(np.median(seconds)) if seconds else None
    seed = entry.group.config.get("seed", entry.run.environment["seed"])
    return more | _compared(entry.group, level, seed)


TABLE = Table(
    id="dt07_chain",
    title="Levels of detail from the level before, against clustering each anew",
    source='DeCoro & Tatarchuk 2007, alternate pass 2: "lower levels almost free", no figures published',
    groups=groups,
    own=own,
    columns=(
        Column("dataset", "dataset", brief=True),
        Column("triangles_in", "triangles in"),
        Column("system", "up to level, or anew", brief=True),
        Column("level", "level"),
        Column("cells", "cells of the first level, or anew"),
        Column("triangles_out", "triangles of the level", brief=True),
        Column("vertices_out", "points of the level"),
        *WALL_COLUMNS,
        Column("stage_s", "device time", "s"),
        Column("level_s", "of it the level's", "s", brief=True),
        *brief(
            (
                *interval_columns("share", "levels after the first, share of the first", ""),
                *interval_columns("chain_ratio", "times faster than all levels anew", ""),
                *interval_columns("level_ratio", "device time: times faster than the level anew", ""),
            ),
            "share", "chain_ratio", "level_ratio",
        ),
        *QUALITY_COLUMNS,
        Column("memory_bytes", "memory", "B"),
    ),
    notes=(
        "level_1 is quadric clustering to a tenth; level_2 to level_4 are whole frames of chains that end there, and "
        "anew_2 to anew_4 cluster the mesh itself on the grid of that level. Both have the same triangles, and points "
        "to the rounding of their sums, so that the errors that stand with anew_k are those of level k.",
        "The share is the wall time of a chain over that of the first level alone, less 1, turn by turn. Against all "
        "levels anew stands the wall time of level_1 and of anew_2 up to the level, of the same turn.",
        "A level by itself has device time alone, without what passes between launches.",
    ),
)  # fmt: skip
