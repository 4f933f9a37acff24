"""Two runs side by side: matched rows, how their times relate, and whether the second is a regression."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from lodbench.harness.record.record import RunRecord, SubjectRecord
from lodbench.harness.report.statistics import unpaired_ratio

THRESHOLD = 0.10  # a slowdown below this share is no regression, however sure
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
        ("rms_error_a", "error A", "1"),
        ("rms_error_b", "error B", "1"),
        ("triangles_a", "triangles A", ""),
        ("triangles_b", "triangles B", ""),
        ("verdict", "verdict", ""),
        ("why", "why", ""),
    )
]


def _subjects(run: RunRecord) -> Iterator[tuple[tuple[str, str, str], SubjectRecord]]:
    for group in run.groups:
        for subject in group.subjects.values():
            # files of one's own are the same only if their content is
            name = " ".join(filter(None, (group.name, group.facts.get("content"))))
            yield (group.table, name, subject.label), subject


def _quality(subject: SubjectRecord | None, key: str) -> float | None:
    return ((subject and subject.quality) or {}).get(key)


def compare(
    a: RunRecord,
    b: RunRecord,
    threshold: float = THRESHOLD,
    keep: re.Pattern[str] | None = None,
) -> dict[str, Any]:
    """Every row that either run has, with the ratio of median wall times b / a and its 95 % interval.

    A row is a `regression` when b failed or was skipped where a had passed, when the whole interval lies above
    1 + threshold, or when the result is worse: a larger error beyond `ERRORS`, more open, non-manifold or flipped edges
    and triangles, another number of triangles; `why` names each. It is `faster` when the whole interval lies below
    1 - threshold; otherwise `same`. Rows of one run only are `missing` or `new`. With fewer than 3 samples on a side
    there is no interval, and nothing is said of time (`too few`).

    Raises:
        ValueError: no row is in both.
    """
    before, after = dict(_subjects(a)), dict(_subjects(b))
    rows = []
    for key in [*before, *(key for key in after if key not in before)]:
        if keep is not None and not keep.search(" ".join(key)):
            continue
        old, new = before.get(key), after.get(key)
        row: dict[str, Any] = dict(zip(("table", "group", "system"), key, strict=True))
        row |= {
            "status_a": old.status if old else None,
            "status_b": new.status if new else None,
            "ratio": None, "ratio_low": None, "ratio_high": None, "wall_s_a": None, "wall_s_b": None,
            "rms_error_a": _quality(old, "rms_error"), "rms_error_b": _quality(new, "rms_error"),
            "triangles_a": old.counters.get("triangles") if old else None,
            "triangles_b": new.counters.get("triangles") if new else None,
        }  # fmt: skip
        row["verdict"], row["why"] = _verdict(row, old, new, threshold)
        rows.append(row)
    if not any(row["verdict"] not in ("missing", "new") for row in rows):
        raise ValueError(f"B: expected a run that has rows of {a.folder}, got none in {b.folder}")
    machines = [
        (run.environment["device"]["name"], run.environment["machine"]["cpu"]) for run in (a, b)
    ]
    return {
        "a": str(a.folder),
        "b": str(b.folder),
        "same_machine": machines[0] == machines[1],
        "threshold": threshold,
        "rows": rows,
        "regressions": sum(row["verdict"] in WORSE for row in rows),
    }


def _verdict(
    row: dict[str, Any], old: SubjectRecord | None, new: SubjectRecord | None, threshold: float
) -> tuple[str, str]:
    """The verdict, and why."""
    if new is None:
        return "missing", "in A alone"
    if old is None:
        return "new", "in B alone"
    if old.status == "ok" and new.status != "ok":
        return "regression", f"{new.status}: {new.reason}"
    if old.status != "ok":
        return "not measured", f"A: {old.status}"
    worse = _worse_results(row, old, new)
    first, second = list(old.wall_s.values()), list(new.wall_s.values())
    verdict, ratio = "not measured", unpaired_ratio(second, first)
    if ratio is not None:
        row |= {
            "ratio": ratio.median, "ratio_low": ratio.low, "ratio_high": ratio.high,
            "wall_s_a": float(np.median(first)), "wall_s_b": float(np.median(second)),
        }  # fmt: skip
        verdict = "too few"
        if ratio.low is not None and ratio.high is not None:
            verdict = "faster" if ratio.high < 1 - threshold else "same"
            if ratio.low > 1 + threshold:
                worse.append("slower")
    return ("regression" if worse else verdict), "; ".join(worse)


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
