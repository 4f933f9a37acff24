"""A short run against recorded ones, on any machine: what got slower beside NumPy, or beside copying memory.

A time is taken as a multiple of its baseline's: of the NumPy form of the same work in the same group, turn by turn;
where there is none, of the time in which the device copies a byte, measured in the same run. What a faster machine does
to both drops out, and what a change of the code did to one stays.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from lodbench.harness.plan import registry
from lodbench.harness.plan.group import Group
from lodbench.harness.plan.table import Table
from lodbench.harness.record.record import RUN, GroupRecord, RunRecord, SubjectRecord, read_run
from lodbench.harness.report import derive
from lodbench.harness.report.compare import compare, named

THRESHOLD = 0.20  # two machines differ by so much in what caches and cores do for one side alone
SECONDS = 60.0  # that the chosen groups took when they were recorded
LEAST_S = 5e-4  # of a frame: below, launches and clocks are most of it
PLAIN = "numpy_"  # what the names of the NumPy forms begin with


def baseline(group: GroupRecord) -> SubjectRecord | None:
    """The group's NumPy form, if it ran and was right."""
    plain = (s for s in group.subjects.values() if s.system.startswith(PLAIN))
    return next((s for s in plain if s.status == "ok" and s.samples), None)


def relative(run: RunRecord, group: GroupRecord, subject: SubjectRecord) -> list[float]:
    """Wall times as multiples of the baseline's; none of what runs on the host, which is no work of ours.

    Bytes that the device copies meanwhile where the group has no NumPy form, and none without either.
    """
    owner = registry.registry().systems.get(subject.system)
    if owner is None or owner.runs_on != "device":
        return []
    plain = baseline(group)
    if plain is not None:
        theirs = plain.wall_s
        return [
            s / theirs.get(turn, np.median([*theirs.values()]))
            for turn, s in subject.wall_s.items()
        ]
    if run.limits is None:
        return []
    return [s * run.limits["copy"]["median"] for s in subject.wall_s.values()]


def recorded(folder: Path) -> list[RunRecord]:
    """The runs within `folder`, or the one that it is, latest first.

    Raises:
        ValueError: there is none.
    """
    found = [read_run(path.parent) for path in sorted(folder.rglob(RUN))]
    if not found:
        raise ValueError(f"reference: expected a folder with recorded runs, got {folder}")
    return sorted(found, key=lambda run: run.environment["started"], reverse=True)


def chosen(
    runs: Sequence[RunRecord], seconds: float = SECONDS
) -> Iterator[tuple[RunRecord, list[Table]]]:
    """Of each table the group that took least when it was recorded last, the quickest tables while time lasts.

    Groups with frames under half a millisecond come after those with none.

    Yields:
        A recorded run, and its tables with that group alone. Groups whose dataset is not here, or that the table no
        longer has, are passed over.
    """
    found: dict[str, tuple[float, RunRecord, Table]] = {}
    for run in runs:
        for table in derive.tables_of(run):
            if table.id in found:
                continue
            now = {g.name: g for g in table.groups(bool(run.environment["options"].get("quick")))}
            for group in sorted(run.of_table(table.id), key=_order):
                mine = now.get(group.name)
                if mine is not None and _same(mine, group):
                    alone = replace(table, groups=lambda quick, mine=mine: [mine])
                    found[table.id] = group.seconds, run, alone
                    break
    spent = 0.0
    kept: dict[int, list[Table]] = {}
    for took, run, table in sorted(found.values(), key=lambda entry: entry[0]):
        if spent + took <= seconds or not spent:
            kept.setdefault(runs.index(run), []).append(table)
            spent += took
    for number, tables in kept.items():
        yield runs[number], tables


def _order(group: GroupRecord) -> tuple[bool, float]:
    frames = [float(np.median([*s.wall_s.values()])) for s in group.subjects.values() if s.samples]
    return min(frames, default=0.0) < LEAST_S, group.seconds


def _same(mine: Group, recorded: GroupRecord) -> bool:
    """Is it the same work on the same dataset?"""
    try:
        dataset = mine.found()
    except ValueError:
        return False
    content = recorded.facts.get("content", "")
    return dataset.name == recorded.dataset and dataset.content == content


def judged(
    before: RunRecord, after: RunRecord, threshold: float = THRESHOLD
) -> list[dict[str, Any]]:
    """The rows that both runs have, as `compare` gives them of times relative to the baseline; `against` names that.

    Rows of which nothing is said, because they run on the host or one side did not measure them, are left out.
    """
    against = {}
    for group in (*before.groups, *after.groups):
        plain = baseline(group)
        against[named(group)] = plain.label if plain else "copying memory"
    return [
        {**row, "against": against[row["table"], row["group"]]}
        for row in compare(before, after, threshold, times=relative)["rows"]
        if row["verdict"] not in ("missing", "new", "not measured")
    ]
