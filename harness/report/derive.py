"""All that is made from a run's records: tables, figures, pictures, the report. Only pictures need a device."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lodbench.harness.plan import sweep, table
from lodbench.harness.record.foreign import blamed_on
from lodbench.harness.record.record import RUN, RunRecord, read_run
from lodbench.harness.report import document

FULL_ONLY = re.compile(r"_(lower|upper|min|low|high)$|^reason$")  # columns left to the files
NO_REPORT = "no report.html: pip install 'lodbench[report]', then `lodbench report RUN`"
MOST_NOISE = 4  # reasons for noise that a terminal shows one by one


def tables_of(run: RunRecord) -> list[table.Table]:
    """The tables that have whole groups in this run, those of a sweep rebuilt from its options."""
    found = []
    for name in run.tables:
        spec = run.environment["options"].get("sweep")
        if name in table.tables():
            found.append(table.table(name))
        elif spec and spec.get("name") == name:
            with blamed_on(run.folder / RUN, "the sweep that was measured"):
                found.append(sweep.table(sweep.validate(spec)))
    return found


def write_tables(folder: Path) -> list[dict[str, Any]]:
    """Write every table of the run; returns the documents."""
    run = read_run(folder)
    return [document.write(one, run) for one in tables_of(run)]


def write_report(folder: Path) -> Path | None:
    """Figures and `report.html` of a run whose tables are written; None without the report extra's packages."""
    try:
        from lodbench.harness.report import page
    except ImportError:
        from lodbench.harness.report import plots

        plots.write_figures(folder)
        return None
    return page.write_report(folder)


def draw_pictures(folder: Path, device_name: str | None) -> str:
    """The run's pictures; returns why there are none, or "".

    They need a device that can hold an image, and the package that writes PNG files.
    """
    from lodbench.harness.report import pictures
    from lodbench.kernels.opencl import Device, Unsupported

    try:
        pictures.write_pictures(folder, Device.open(device_name))
    except (ImportError, Unsupported) as reason:
        return f"no pictures: {reason}"
    return ""


def brief_keys(run: RunRecord) -> dict[str, list[str]]:
    """Table -> keys of the columns that a terminal shows, where it says which."""
    return {one.id: one.brief for one in tables_of(run)}


def brief_columns(folder: Path, made: dict[str, Any]) -> list[dict[str, str]]:
    """The columns of a document that a terminal shows."""
    keys = brief_keys(read_run(folder)).get(made["id"], ())
    if keys:
        return [column for key in keys for column in made["columns"] if column["key"] == key]
    return [column for column in made["columns"] if not FULL_ONLY.search(column["key"])]


def reasons(made: dict[str, Any]) -> list[str]:
    """Why rows are not ok or lack a ratio, one line per reason, with the rows that share it; much noise is one line."""
    found: dict[tuple[str, str], list[str]] = {}
    for row in made["rows"]:
        who = f"{row.get('dataset') or ''} {row.get('system')}".strip()
        for reason in filter(None, re.split("; (?=no ratio to |too few )", row["reason"] or "")):
            lacks = reason.startswith("no ratio to ")
            key = ("no ratio", reason[len("no ratio ") :]) if lacks else (row["status"], reason)
            if reason.startswith("too few "):
                key = ("no interval", reason)
            found.setdefault(key, []).append(who)
    noisy = [key for key in found if key[0] == "noisy"]
    rest = len(noisy) > MOST_NOISE
    lines = [
        f"{status}: {reason} ({', '.join(who) if len(who) < 4 else f'{len(who)} rows'})"
        for (status, reason), who in found.items()
        if status != "noisy" or not rest
    ]
    if rest:
        rows = sum(len(found[key]) for key in noisy)
        lines.append(f"noisy: {rows} rows, the reason of each stands in tables/{made['id']}.csv")
    return lines


def statuses(documents: Sequence[dict[str, Any]]) -> dict[str, int]:
    """How many rows have which status."""
    counts: dict[str, int] = {}
    for made in documents:
        for row in made["rows"]:
            counts[row["status"]] = counts.get(row["status"], 0) + 1
    return counts
