"""A run's measurements as plain rows, for pandas, polars or a loop of one's own; no device is opened, nothing written.

```python
from lodbench.harness import records

rows = records.load("results/reference/pocl-amd-epyc/2026-11-28-a1398e8", table="dt07_timing")
frame = pandas.DataFrame(rows)  # or polars.DataFrame(rows)
```
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lodbench.harness.plan.table import Row
from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord, plain, read_run
from lodbench.harness.report.derive import tables_of
from lodbench.harness.report.rows import measured, table_rows
from lodbench.kernels.parameters import closest

FIRST = ("table", "dataset", "system", "status", "reason")  # keys that stand before all others


def load(
    run: str | Path, table: str | None = None, *, samples: bool = False
) -> list[dict[str, Any]]:
    """A row per subject and case, or per sample: flat, every row with the same keys in the same order.

    Args:
        run: a run's folder, packed or not; nothing is written into it.
        table: the rows of this table alone; None gives those of all.
        samples: a row for every timed frame, warm-ups among them and flagged, instead of one for all of a subject's.

    Returns:
        Dictionaries whose values are text, numbers, bool, tuples (such as three numbers of cells) or None for what is
        not known; seconds, bytes and fractions of the diagonal as in the run's tables. Rows of subjects have what their
        table says (see `harness.report.rows`), and `wall_s_low` and `wall_s_high`, the 95 % interval of the median
        `wall_s`. Rows of samples have the case's facts, the fields of the record, and `stage_<name>_s`.

    Raises:
        ValueError: not a run's folder, or no such table in it.
    """
    found = read_run(Path(run))
    if table is not None and table not in found.tables:
        raise ValueError(closest("table", table, found.tables))
    names = [table] if table is not None else found.tables
    rows = [row for name in names for row in (_samples if samples else _subjects)(found, name)]
    keys = dict.fromkeys((*FIRST, *(key for row in rows for key in row)))
    return [{key: _value(row.get(key)) for key in keys} for row in rows]


def _value(value: Any) -> Any:
    """A list as a tuple, by which frames can group; anything else that is not flat as text."""
    value = plain(value)
    if isinstance(value, list):
        return tuple(_value(item) for item in value)
    return str(value) if isinstance(value, Mapping) else value


def _subjects(run: RunRecord, name: str) -> list[Row]:
    """The table's rows; those that every table has where this version knows no such table."""
    known = [table for table in tables_of(run) if table.id == name]
    rows = table_rows(known[0], run) if known else [
        measured(group, subject)
        for group in run.of_table(name)
        for subject in group.subjects.values()
    ]  # fmt: skip
    return [{"table": name, **row} for row in rows]


def _samples(run: RunRecord, name: str) -> list[Row]:
    return [
        row
        for group in run.of_table(name)
        for subject in group.subjects.values()
        for row in _of_subject(group, subject)
    ]


def _of_subject(group: GroupRecord, subject: SubjectRecord) -> list[Row]:
    about = {
        "table": group.table, **group.facts, "dataset": group.dataset, "system": subject.label,
        "status": subject.status, "reason": subject.reason,
    }  # fmt: skip
    taken = sorted((*subject.warmups, *subject.samples), key=lambda row: row["turn"])
    return [
        {
            **about,
            **{key: row.get(key) for key in ("turn", "warmup", "wall_s", "cpu_s", "load")},
            **{f"stage_{stage}_s": seconds for stage, seconds in row["stage_s"].items()},
        }
        for row in taken
    ]
