"""A table as it is written: JSON for programs, Markdown for people, CSV in full precision, LaTeX for papers."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lodbench.datasets_gen.files import write_file
from lodbench.harness.plan.table import STATUS_COLUMNS, Table
from lodbench.harness.record.foreign import blamed_on
from lodbench.harness.record.record import RunRecord, plain, write_json
from lodbench.harness.record.samples import rows_file
from lodbench.harness.report.amounts import amount
from lodbench.harness.report.latex import latex
from lodbench.harness.report.rows import table_rows


def document(table: Table, run: RunRecord) -> dict[str, Any]:
    """The table as it is written: every row has every column's key."""
    rows = table_rows(table, run)
    columns = [*table.columns]
    have = {column.key for column in columns}
    columns += [column for column in STATUS_COLUMNS if column.key not in have]
    keys = [column.key for column in columns]
    return {
        "id": table.id,
        "title": table.title,
        "source": table.source,
        "device": run.environment["device"]["name"],
        "columns": [{"key": c.key, "label": c.label, "unit": c.unit} for c in columns],
        "rows": [plain({key: row.get(key) for key in keys}) for row in rows],
        "notes": list(table.notes),
    }


def markdown(made: Mapping[str, Any]) -> str:
    """The document as Markdown; columns without a single value are left out."""
    columns = [
        column
        for column in made["columns"]
        if any(row[column["key"]] not in (None, "") for row in made["rows"])
    ]
    lines = [f"# {made['title']}", "", f"{made['source']}. Device: {made['device']}.", ""]
    if made["rows"]:
        lines.append("| " + " | ".join(column["label"] for column in columns) + " |")
        lines.append("|" + " --- |" * len(columns))
    for row in made["rows"]:
        cells = [amount(row[column["key"]], column["unit"]) for column in columns]
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    if made["notes"]:
        lines += ["", *(f"- {note}" for note in made["notes"])]
    return "\n".join(lines) + "\n"


def comma_separated(made: Mapping[str, Any]) -> str:
    """The document's rows as CSV, in full precision; None is empty."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    keys = [column["key"] for column in made["columns"]]
    writer.writerow(keys)
    for row in made["rows"]:
        writer.writerow("" if row[key] is None else row[key] for key in keys)
    return text.getvalue()


def write(table: Table, run: RunRecord) -> dict[str, Any]:
    """Write `tables/<id>.json`, `.md`, `.csv` and `.tex` into the run's folder; returns the document."""
    with blamed_on(rows_file(Path(run.folder)), f"the fields of table {table.id}"):
        made = document(table, run)
        text, paper = markdown(made), latex(made, table.brief)
    folder = Path(run.folder) / "tables"
    folder.mkdir(parents=True, exist_ok=True)
    write_json(folder / f"{table.id}.json", made)
    write_file(folder / f"{table.id}.md", text)
    write_file(folder / f"{table.id}.csv", comma_separated(made))
    write_file(folder / f"{table.id}.tex", paper)
    return made
