"""Two runs side by side: matched rows, how their times relate, and whether the second is a regression."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from lodbench.harness.record import RunRecord, SubjectRecord
from lodbench.harness.timing import unpaired_ratio

THRESHOLD = 0.10  # a slowdown below this share is no regression, however sure
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
        ("verdict", "verdict", ""),
    )
]


def _subjects(run: RunRecord) -> Iterator[tuple[tuple[str, str, str], SubjectRecord]]:
    for group in run.groups:
        for subject in group.subjects.values():
            yield (group.table, group.name, subject.label), subject


def _quality(subject: SubjectRecord) -> float | None:
    return (subject.quality or {}).get("rms_error")


def compare(
    a: RunRecord,
    b: RunRecord,
    threshold: float = THRESHOLD,
    keep: re.Pattern[str] | None = None,
) -> dict[str, Any]:
    """Every row that either run has, with the ratio of median wall times b / a and its 95 % interval.

    A row is a `regression` when b failed where a had passed, or when the whole interval lies above 1 + threshold;
    `faster` when the whole interval lies below 1 - threshold; otherwise `same`. Rows of one run only are `missing`
    or `new`. With fewer than 3 samples on a side there is no interval, and nothing is said (`too few`).
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
            "rms_error_a": _quality(old) if old else None,
            "rms_error_b": _quality(new) if new else None,
        }  # fmt: skip
        row["verdict"] = _judge(row, old, new, threshold)
        rows.append(row)
    machines = [
        (run.environment["device"]["name"], run.environment["machine"]["cpu"]) for run in (a, b)
    ]
    return {
        "a": str(a.folder),
        "b": str(b.folder),
        "same_machine": machines[0] == machines[1],
        "threshold": threshold,
        "rows": rows,
        "regressions": sum(row["verdict"] == "regression" for row in rows),
    }


def _judge(
    row: dict[str, Any], old: SubjectRecord | None, new: SubjectRecord | None, threshold: float
) -> str:
    if new is None:
        return "missing"
    if old is None:
        return "new"
    if old.status == "ok" and new.status == "failed":
        return "regression"
    if old.status != "ok" or new.status != "ok":
        return "not measured"
    first, second = list(old.wall_s.values()), list(new.wall_s.values())
    ratio = unpaired_ratio(second, first)
    if ratio is None:
        return "not measured"
    row |= {
        "ratio": ratio.median, "ratio_low": ratio.low, "ratio_high": ratio.high,
        "wall_s_a": float(np.median(first)), "wall_s_b": float(np.median(second)),
    }  # fmt: skip
    if ratio.low is None or ratio.high is None:
        return "too few"
    if ratio.low > 1 + threshold:
        return "regression"
    return "faster" if ratio.high < 1 - threshold else "same"
