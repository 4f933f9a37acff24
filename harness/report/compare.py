"""Two runs side by side: matched rows, how their times relate, and whether the second is a regression."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from math import comb
from typing import Any

import numpy as np
from scipy import stats

from lodbench.harness.measure.precision import ENOUGH
from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.report.statistics import NOISY_OTHERS, unpaired_ratio

THRESHOLD = 0.05  # a slowdown below this share is no regression, however sure
LEVEL = 0.05
"""The chance that a comparison of two runs of the same code calls any of its rows slower, or any faster."""
ERRORS = {"rms_error": 0.01, "rms_error_back": 0.01, "max_error": 0.05}
"""How much larger, as a share, an error may be. With one seed a mesh is sampled alike to the bit; another seed, or
other roundings of the same vertices, move a root mean square by less than this, and the largest of all samples more."""
TOPOLOGY = ("open_edges", "nonmanifold_edges", "flipped_triangles")
WORSE = ("regression", "missing", "new")
"""Verdicts for which a comparison fails."""
COLUMNS = [
    {"key": key, "label": label, "unit": unit}
    for key, label, unit in (
        ("table", "table", ""),
        ("group", "group", ""),
        ("system", "system", ""),
        ("wall_s_a", "A", "s"),
        ("wall_s_b", "B", "s"),
        ("ratio", "B / A", "1"),
        ("ratio_low", "low", "1"),
        ("ratio_high", "high", "1"),
        ("p", "p", "1"),
        ("rms_error_a", "error A", "1"),
        ("rms_error_b", "error B", "1"),
        ("triangles_a", "triangles A", ""),
        ("triangles_b", "triangles B", ""),
        ("verdict", "verdict", ""),
        ("why", "why", ""),
    )
]


Times = Callable[[RunRecord, GroupRecord, SubjectRecord], Sequence[float]]
_NONE: tuple[SubjectRecord | None, Sequence[float]] = None, ()


def _subjects(
    run: RunRecord, times: Times
) -> Iterator[tuple[tuple[str, str, str], tuple[SubjectRecord, Sequence[float]]]]:
    for group in run.groups:
        for subject in group.subjects.values():
            yield (*named(group), subject.label), (subject, times(run, group, subject))


def named(group: GroupRecord) -> tuple[str, str]:
    """The table and the name that a group's rows have: files of one's own are the same only if their content is."""
    return group.table, " ".join(filter(None, (group.name, group.facts.get("content"))))


def _disturbed(run: RunRecord) -> set[tuple[str, str]]:
    """The groups while which other processes took so much of the machine that their rows are noisy for it."""
    return {named(group) for group in run.groups if group.others > NOISY_OTHERS}


def _quality(subject: SubjectRecord | None, key: str) -> float | None:
    return ((subject and subject.quality) or {}).get(key)


def compare(
    a: RunRecord,
    b: RunRecord,
    threshold: float = THRESHOLD,
    keep: re.Pattern[str] | None = None,
    times: Times = lambda run, group, subject: list(subject.wall_s.values()),
) -> dict[str, Any]:
    """Every row that either run has, with the ratio of median wall times b / a and its 95 % interval.

    A row is a `regression` when b failed or was skipped where a had passed, when it is slower, or when the result is
    worse: a larger error beyond `ERRORS`, more open, non-manifold or flipped edges and triangles, another number of
    triangles; `why` names each. It is slower when its times in b are longer than 1 + threshold times those in a by the
    rank sum test of Mann & Whitney, and `faster` when they are shorter than 1 - threshold times; otherwise `same`. The
    more rows, the surer each must be: by Holm's procedure, two runs of the same code have any row called slower in one
    of twenty comparisons at the most (`LEVEL`), whatever the number of rows. `p` is that test's, of the direction that
    the ratio has. With fewer than 6 samples on a side, or too few for any result to be sure enough, nothing is said of
    time (`too few`); nor where other processes took so much of the machine that a run's rows are noisy for it
    (`busy`). Rows of one run only are `missing` or `new`.

    Args:
        a: the run to compare with.
        b: the run in question.
        threshold: a slowdown below this share is none.
        keep: only rows whose table, group and system it is found in.
        times: what is compared of a subject, one number per sample.

    Raises:
        ValueError: no row is in both.

    Source: Mann & Whitney 1947; Holm 1979, A Simple Sequentially Rejective Multiple Test Procedure.
    """
    before, after = dict(_subjects(a, times)), dict(_subjects(b, times))
    disturbed = _disturbed(a) | _disturbed(b)
    rows = []
    for key in [*before, *(key for key in after if key not in before)]:
        if keep is not None and not keep.search(" ".join(key)):
            continue
        (old, first), (new, second) = before.get(key, _NONE), after.get(key, _NONE)
        row: dict[str, Any] = dict(zip(("table", "group", "system"), key, strict=True))
        row |= {
            "status_a": old.status if old else None,
            "status_b": new.status if new else None,
            "ratio": None, "ratio_low": None, "ratio_high": None, "p": None,
            "wall_s_a": None, "wall_s_b": None,
            "rms_error_a": _quality(old, "rms_error"), "rms_error_b": _quality(new, "rms_error"),
            "triangles_a": old.counters.get("triangles") if old else None,
            "triangles_b": new.counters.get("triangles") if new else None,
        }  # fmt: skip
        row["verdict"], row["why"] = _verdict(row, old, new, first, second, threshold)
        if row["verdict"] == "timed" and key[:2] in disturbed:
            row["verdict"], row["p"] = "regression" if row["why"] else "busy", None
            del row["least_p"]
        rows.append(row)
    if not any(row["verdict"] not in ("missing", "new") for row in rows):
        raise ValueError(f"B: expected a run that has rows of {a.folder}, got none in {b.folder}")
    _judge_times(rows)
    machines = [
        (run.environment["device"]["name"], run.environment["machine"]["cpu"]) for run in (a, b)
    ]
    return {
        "a": str(a.folder),
        "b": str(b.folder),
        "same_machine": machines[0] == machines[1],
        "threshold": threshold,
        "level": LEVEL,
        "rows": rows,
        "regressions": sum(row["verdict"] in WORSE for row in rows),
        "too_few": sum(row["verdict"] == "too few" for row in rows),
        "busy": sum(row["verdict"] == "busy" for row in rows),
    }


def confirm(found: dict[str, Any], again: Sequence[dict[str, Any]]) -> None:
    """Leave a row slower only where it is so in these comparisons too, of further runs of B's code with A.

    They are made with half the threshold: that a row was slower beyond it is known, and what chance adds is not.
    Frames are up to a quarter slower in one process than in the next, by where its buffers lie and by what else the
    host does: samples of one run do not know of that, and a second run does.
    """
    key = ("table", "group", "system")
    slower = [
        {tuple(row[k] for k in key) for row in one["rows"] if "slower" in row["why"].split("; ")}
        for one in again
    ]
    for row in found["rows"]:
        why = row["why"].split("; ")
        if "slower" in why and not all(tuple(row[k] for k in key) in one for one in slower):
            why.remove("slower")
            row["verdict"] = "regression" if why else "unconfirmed"
            row["why"] = "; ".join(why)
    found["regressions"] = sum(row["verdict"] in WORSE for row in found["rows"])


def _verdict(
    row: dict[str, Any],
    old: SubjectRecord | None,
    new: SubjectRecord | None,
    first: Sequence[float],
    second: Sequence[float],
    threshold: float,
) -> tuple[str, str]:
    """The verdict on all but time, and why; `timed` where time is still to be judged."""
    if new is None:
        return "missing", "in A alone"
    if old is None:
        return "new", "in B alone"
    if old.status == "ok" and new.status != "ok":
        return "regression", f"{new.status}: {new.reason}"
    if old.status != "ok":
        return "not measured", f"A: {old.status}"
    worse = "; ".join(_worse_results(row, old, new))
    ratio = unpaired_ratio(second, first)
    if ratio is None:
        return ("regression" if worse else "not measured"), worse
    row |= {
        "ratio": ratio.median, "ratio_low": ratio.low, "ratio_high": ratio.high,
        "wall_s_a": float(np.median(list(old.wall_s.values()))),
        "wall_s_b": float(np.median(list(new.wall_s.values()))),
    }  # fmt: skip
    if min(len(first), len(second)) < ENOUGH:
        return ("regression" if worse else "too few"), worse
    slower = ratio.median > 1
    edge = 1 + threshold if slower else 1 - threshold
    test: Any = stats.mannwhitneyu(
        second, edge * np.asarray(first), alternative="greater" if slower else "less"
    )
    row["p"] = float(test.pvalue)
    row["least_p"] = 1 / comb(len(first) + len(second), len(first))
    return "timed", worse


def _judge_times(rows: Sequence[dict[str, Any]]) -> None:
    """Put a verdict in place of `timed`, and take out what it was made of."""
    timed = [row for row in rows if row["p"] is not None]
    sure = True
    for number, row in enumerate(sorted(timed, key=lambda row: row["p"])):
        # the surest row must be sure at the level over all rows, the next over all but one, until one is not
        sure = sure and row["p"] <= LEVEL / (len(timed) - number)
        could = row.pop("least_p") <= LEVEL / len(timed)
        if sure and row["ratio"] > 1:
            row["why"] = "; ".join(filter(None, (row["why"], "slower")))
        row["verdict"] = "faster" if sure else "same" if could else "too few"
        if row["why"]:
            row["verdict"] = "regression"


def _worse_results(row: dict[str, Any], old: SubjectRecord, new: SubjectRecord) -> list[str]:
    """What is worse about what came out, in words."""
    found = []
    for key, tolerance in ERRORS.items():
        before, after = _quality(old, key), _quality(new, key)
        if before is not None and after is not None and after > before * (1 + tolerance):
            found.append(f"{key} {before:.3g} -> {after:.3g}")
    for key in TOPOLOGY:
        before, after = _quality(old, key), _quality(new, key)
        if before is not None and after is not None and after > before:
            found.append(f"{key} {before} -> {after}")
    before, after = row["triangles_a"], row["triangles_b"]
    if before is not None and after is not None and before != after:
        found.append(f"triangles {before:,} -> {after:,}")
    return found
