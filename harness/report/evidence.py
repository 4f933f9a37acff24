"""The cases that runs have of what a claim needs: ratios, numbers of tables' rows, shares of stages."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from typing import Any

import numpy as np

from lodbench.harness.claims import Comparison, Evidence, Pick, Rows, Share
from lodbench.harness.measure.precision import median_interval
from lodbench.harness.plan.table import Row, Table, tables
from lodbench.harness.record.foreign import blamed_on
from lodbench.harness.record.record import RUN, GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.report.ratios import counts, like
from lodbench.harness.report.rows import table_rows
from lodbench.harness.report.statistics import paired_ratio

_COUNTS: Mapping[str, Callable[[SubjectRecord], float | None]] = {
    "closer": lambda subject: (subject.quality or {}).get("rms_error"),
    "fewer triangles": lambda subject: subject.counters.get("triangles"),
    "fewer KSQuads": lambda subject: subject.counters.get("quads_kept"),
    "fewer stored vertices": lambda subject: subject.footprint.get("stored_vertices"),
}
_TARGETS = {"target_count", "target_reduction"}  # asked for; what came out must be alike


@dataclass(frozen=True)
class Measured:
    """One case: a ratio, or in its place the number or share, in one group of one run.

    The interval is the ratio itself where nothing was sampled. `holds` is None where the interval has both outcomes, or
    where there is none.
    """

    run: str
    group: str
    subject: str
    ratio: float
    low: float | None
    high: float | None
    holds: bool | None


class Tables:
    """The rows of runs' tables, each computed when it is first asked for."""

    def __init__(self) -> None:
        self._known: dict[tuple[int, str, str], list[Row]] = {}

    def rows(self, run: RunRecord, name: str, column: str) -> list[Row]:
        """The rows of this table with all of its columns, but of its ratios with this one at the most."""
        ratio = column if _is_ratio(column) else ""
        key = id(run), name, ratio
        if key not in self._known:
            table = tables().get(name)
            self._known[key] = table_rows(_narrowed(table, ratio), run) if table else []
        return self._known[key]


def _is_ratio(column: str) -> bool:
    return column.startswith(("ratio_to_", "frame_ratio_to_"))


def _narrowed(table: Table, ratio: str) -> Table:
    """The table without its other ratios, whose intervals take seconds."""
    kept = [column for column in table.columns if not _is_ratio(column.key) or column.key == ratio]
    return replace(table, columns=kept)


def _subjects(group: GroupRecord, pick: Pick) -> list[SubjectRecord]:
    return [
        subject
        for subject in group.subjects.values()
        if subject.system == pick.system
        and counts(subject)
        and all((subject.params or {}).get(key) == value for key, value in pick.params.items())
        and not any((subject.params or {}).get(key) == value for key, value in pick.without.items())
        and not _one_core(group, subject.label)
    ]


def _alike(comparison: Comparison, one: SubjectRecord, other: SubjectRecord) -> bool:
    """Two subjects whose parameters of the same name are the same, but for those that the comparison is of."""
    picked = {*comparison.subject.params, *comparison.other.params}
    ours, theirs = (subject.params or {} for subject in (one, other))
    shared = ours.keys() & theirs.keys() - picked
    asked = any(ours.get(key) or theirs.get(key) for key in _TARGETS & shared)
    return (
        one is not other
        and all(ours[key] == theirs[key] for key in shared - _TARGETS)
        and (not asked or like(one, other))
    )


def _one_core(group: GroupRecord, label: str) -> bool:
    subjects = group.config.get("subjects", ())
    return any(one["label"] == label and one.get("one_core") for one in subjects)


def _drawn(group: GroupRecord, label: str) -> bool:
    """Is a sample of this subject a whole frame?"""
    subjects = group.config.get("subjects", ())
    draws = [one.get("draw") for one in subjects if one["label"] == label]
    return any(draw and not draw.get("apart") for draw in draws)


def _stages(subject: SubjectRecord, names: Sequence[str]) -> dict[int, float]:
    """Turn -> device seconds of these stages; nothing where one of them did not run."""
    if not set(names) <= set(subject.stages):
        return {}
    turns = (row["turn"] for row in subject.samples)
    return dict(zip(turns, subject.stage_s(*names), strict=True))


def _ratio(
    comparison: Comparison, group: GroupRecord, one: SubjectRecord, other: SubjectRecord, seed: int
) -> tuple[float, float | None, float | None] | None:
    count = _COUNTS.get(comparison.what)
    if count is not None:
        ours, theirs = count(one), count(other)
        if not (ours and theirs):
            return None
        ratio = theirs / ours
        return ratio, ratio, ratio
    whole = all(_drawn(group, subject.label) for subject in (one, other))
    if comparison.what == "frames faster":
        times = (other.wall_s, one.wall_s) if whole else (other.frame_s, one.frame_s)
    elif comparison.stage:
        times = other.stage_by_turn(comparison.stage), one.stage_by_turn(comparison.stage)
    elif whole:
        return None  # samples with drawing say little of the stages before it
    else:
        times = other.wall_s, one.wall_s
    found = paired_ratio(*times, seed)
    return (found.median, found.low, found.high) if found else None


def _holds(evidence: Evidence, low: float | None, high: float | None) -> bool | None:
    """Does the whole interval keep to what the claim allows; None where a part does, or there is none."""
    if low is None or high is None:
        return None
    least = -np.inf if evidence.least is None else evidence.least
    most = np.inf if evidence.most is None else evidence.most
    if least <= low and high <= most:
        return True
    return False if high < least or most < low else None


def _name(run: RunRecord) -> str:
    return run.folder.name


def _compared(comparison: Comparison, run: RunRecord) -> Iterator[Measured]:
    """The comparison in each of the run's groups that has both subjects, for each pair of them."""
    for group in run.groups if comparison.table is None else run.of_table(comparison.table):
        if any(group.facts.get(key) != value for key, value in comparison.facts.items()):
            continue
        seed = group.config.get("seed", run.environment["seed"])
        for one in _subjects(group, comparison.subject):
            for other in _subjects(group, comparison.other):
                found = _ratio(comparison, group, one, other, seed)
                if found is not None and _alike(comparison, one, other):
                    name = f"{group.table}: {group.name}"
                    held = _holds(comparison, *found[1:])
                    yield Measured(_name(run), name, one.label, *found, held)


def _shared(share: Share, run: RunRecord) -> Iterator[Measured]:
    for group in run.groups:
        for one in _subjects(group, share.subject):
            ours, all_s = _stages(one, share.stages), one.stage_s()
            if not ours:
                continue
            shares = [part / whole for part, whole in zip(ours.values(), all_s, strict=True)]
            low, high = median_interval(shares)
            name = f"{group.table}: {group.name}"
            value, held = float(np.median(shares)), _holds(share, low, high)
            yield Measured(_name(run), name, one.label, value, low, high, held)


def _fits(row: Row, where: Mapping[str, Any]) -> bool:
    def one(value: Any, wanted: Any) -> bool:
        if isinstance(wanted, tuple):
            return any(one(value, each) for each in wanted)
        if isinstance(value, str) and isinstance(wanted, str):
            return fnmatchcase(value, wanted)
        return value == wanted

    return all(one(row.get(key), wanted) for key, wanted in where.items())


def _listed(rows: Rows, run: RunRecord, known: Tables) -> Iterator[Measured]:
    for row in known.rows(run, rows.table, rows.column):
        value = row.get(rows.column)
        if row["status"] not in ("ok", "noisy") or value is None or not _fits(row, rows.where):
            continue
        ends = (row.get(f"{rows.column}_{end}", value) for end in ("low", "high"))
        low, high = (None if end is None else float(end) for end in ends)
        about = [row.get("dataset"), *(f"{key}={row.get(key)}" for key in _told(rows, row))]
        name = f"{rows.table}: {' '.join(str(word) for word in about if word)}"
        held = _holds(rows, low, high)
        yield Measured(_name(run), name, str(row["system"]), float(value), low, high, held)


def _told(rows: Rows, row: Row) -> list[str]:
    """Columns that tell rows of a case apart."""
    usual = ("level", "levels", "segments", "storage", "coarse_triangles", "triangles_asked", "n")
    return [key for key in usual if row.get(key) is not None and key != rows.column]


def measured(
    evidence: Evidence, runs: Iterable[RunRecord], known: Tables | None = None
) -> list[Measured]:
    """Every case that the runs have of this evidence; those without an interval only where none has one."""
    known = known or Tables()
    found: list[Measured] = []
    for run in runs:
        with blamed_on(run.folder / RUN, "what claims compare"):
            if isinstance(evidence, Rows):
                found += _listed(evidence, run, known)
            elif isinstance(evidence, Share):
                found += _shared(evidence, run)
            else:
                found += _compared(evidence, run)
    return [one for one in found if one.low is not None] or found
