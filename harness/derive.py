"""All that is made from a run's records: tables, figures, the report. Nothing here measures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lodbench.harness import sweep, tables
from lodbench.harness.record import RunRecord, read_run


def tables_of(run: RunRecord) -> list[tables.Table]:
    """The tables that have whole groups in this run, those of a sweep rebuilt from its options."""
    found = []
    for name in run.tables:
        spec = run.environment["options"].get("sweep")
        if name in tables.tables():
            found.append(tables.table(name))
        elif spec and spec["name"] == name:
            found.append(sweep.table(spec))
    return found


def write_tables(folder: Path) -> list[dict[str, Any]]:
    """Write every table of the run; returns the documents."""
    run = read_run(folder)
    return [tables.write(table, run) for table in tables_of(run)]


def write_report(folder: Path) -> Path | None:
    """Figures and `report.html` of a run whose tables are written; None without the report extra's packages."""
    try:
        from lodbench.harness import report
    except ImportError:
        from lodbench.harness import plots

        plots.write_figures(folder)
        return None
    return report.write_report(folder)


def statuses(documents: Sequence[dict[str, Any]]) -> dict[str, int]:
    """How many rows have which status."""
    counts: dict[str, int] = {}
    for made in documents:
        for row in made["rows"]:
            counts[row["status"]] = counts.get(row["status"], 0) + 1
    return counts
