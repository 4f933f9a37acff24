"""Reproduced tables and figures: one file each, cases, columns and published values as data.

A table is made from a run's records alone, any number of times. Each row has `status` (`ok`, `noisy`, `skipped`,
`failed`; `published`: nothing of it was measured) and `reason`; unknown values are None. `ratio_to_<subject>` says how
many times faster the row is than that subject, taken turn by turn, with a 95 % bootstrap interval in `..._low` and
`..._high`; it is None where either of the two failed its check or ran in batches, or where
they leave unlike numbers of triangles: see `harness.ratios`.
"""

from __future__ import annotations

import csv
import importlib
import io
import pkgutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from lodbench.datasets_gen.files import write_file
from lodbench.harness.amounts import amount
from lodbench.harness.foreign import blamed_on
from lodbench.harness.group import Group
from lodbench.harness.limits import Limits
from lodbench.harness.ratios import verdict
from lodbench.harness.record import (
    GroupRecord,
    RunRecord,
    SubjectRecord,
    plain,
    write_json,
)
from lodbench.harness.registry import closest
from lodbench.harness.rows import rows_file
from lodbench.harness.timing import summary
from lodbench.kernels.system import Traffic

Row = dict[str, Any]


@dataclass(frozen=True)
class Column:
    """A column: its key in every row, its label for people, its unit ("" for a count, "1" for a share)."""

    key: str
    label: str
    unit: str = ""


@dataclass(frozen=True)
class Table:
    """A reproduced table.

    Attributes:
        id: the file's name.
        source: paper and figure or section; with the published hardware when there are published values.
        groups: quick -> what to measure.
        rows: the run's record and this table's whole groups in it -> rows.
        notes: what a reader must know, such as inconsistencies of the source.
        brief: keys of the columns that a terminal shows; empty: all but quartiles and intervals.
    """

    id: str
    title: str
    source: str
    groups: Callable[[bool], Sequence[Group]]
    columns: Sequence[Column]
    rows: Callable[[RunRecord, Sequence[GroupRecord]], list[Row]]
    notes: Sequence[str] = field(default_factory=tuple)
    brief: Sequence[str] = field(default_factory=tuple)


@cache
def tables() -> dict[str, Table]:
    """Every table of this package, by id."""
    found = {}
    for module in pkgutil.iter_modules(__path__):
        table = getattr(importlib.import_module(f"{__name__}.{module.name}"), "TABLE", None)
        if isinstance(table, Table):
            found[table.id] = table
    return found


def table(name: str) -> Table:
    """The table of this id.

    Raises:
        ValueError: no such table.
    """
    if name not in tables():
        raise ValueError(closest("table", name, tables()))
    return tables()[name]


STATUS_COLUMNS = (Column("status", "status"), Column("reason", "reason"))
WALL_COLUMNS = (
    Column("wall_s", "median wall", "s"),
    Column("wall_s_min", "least wall", "s"),
    Column("wall_s_lower", "lower quartile", "s"),
    Column("wall_s_upper", "upper quartile", "s"),
    Column("samples", "n"),
)
FRAME_COLUMNS = (
    Column("frame_fps", "frame fps", "1/s"),
    Column("frame_s", "median frame", "s"),
    Column("frame_s_lower", "frame, lower quartile", "s"),
    Column("frame_s_upper", "frame, upper quartile", "s"),
    Column("frames", "frames"),
)
QUALITY_COLUMNS = (
    Column("rms_error", "RMS error", "1"),
    Column("rms_error_back", "RMS error back", "1"),
    Column("max_error", "largest error", "1"),
    Column("open_edges", "open edges"),
    Column("nonmanifold_edges", "non-manifold edges"),
    Column("flipped_triangles", "flipped triangles"),
)


def ratio_columns(subjects: Iterable[str]) -> tuple[Column, ...]:
    """The three columns of the ratio to each of these subjects."""
    return tuple(
        column
        for name in subjects
        for column in (
            Column(f"ratio_to_{name}", f"times faster than {name}", "1"),
            Column(f"ratio_to_{name}_low", f"... than {name}, low", "1"),
            Column(f"ratio_to_{name}_high", f"... than {name}, high", "1"),
        )
    )


def measured(group: GroupRecord, subject: SubjectRecord) -> Row:
    """What every row says of its subject: names, status, wall and stage seconds, counts."""
    wall = list(subject.wall_s.values())
    status, reason = verdict(group, subject)
    row: Row = {
        **group.facts,
        "system": subject.label,
        "status": status,
        "reason": reason,
        "triangles_out": subject.counters.get("triangles"),
        "stored_vertices": subject.footprint.get("stored_vertices"),
        "stored_bytes": subject.footprint.get("stored_bytes"),
        "batches": subject.footprint.get("batches"),
    }
    walls, stages = summary(wall), summary(subject.stage_s())
    row["wall_s"] = walls.median if walls else None
    row["wall_s_min"] = walls.minimum if walls else None
    row["wall_s_lower"] = walls.lower if walls else None
    row["wall_s_upper"] = walls.upper if walls else None
    row["samples"] = len(wall)
    row["stage_s"] = stages.median if stages else None
    frames = summary(list(subject.frame_s.values()))
    row["frames"] = frames.n if frames else None
    row["frame_s"] = frames.median if frames else None
    row["frame_s_lower"] = frames.lower if frames else None
    row["frame_s_upper"] = frames.upper if frames else None
    row["frame_fps"] = 1 / frames.median if frames else None
    row |= {column.key: (subject.quality or {}).get(column.key) for column in QUALITY_COLUMNS}
    return row


def published(group: GroupRecord, system: str, **values: float | None) -> Row:
    """The row of a method that only the paper ran: the group's facts and `published_*` values alone."""
    return {**group.facts, "system": system, "status": "published", **values}


def memory_bytes(group: GroupRecord, subject: SubjectRecord) -> int | None:
    """What the subject holds while it runs: a device's buffers, or a host's input and the rise of its memory peak.

    The rise is a lower bound: memory that a package kept from an earlier call is not counted again, so subjects of
    one system share the highest. None where it is not known; that of a call into the device's pool says nothing.
    """
    parts = ("input_bytes", "pattern_bytes", "output_bytes", "scratch_bytes")
    if subject.stages and subject.stages != ["call"]:
        return sum(subject.footprint.get(part) or 0 for part in parts)
    same = [other for other in group.subjects.values() if other.system == subject.system]
    rises = [other.peak_growth_bytes for other in same if other.peak_growth_bytes is not None]
    if not rises or subject.system == "simplify_call":
        return None
    return (subject.footprint.get("input_bytes") or 0) + max(rises)


def limit_share(run: RunRecord, subject: SubjectRecord) -> float | None:
    """Which share of the device's measured limits its stages reach: least possible over median device time.

    Source: Williams, Waterman & Patterson 2009, Roofline: bytes over bandwidth, or operations over their peak rate.
    """
    stages = {name: summary(subject.stage_s(name)) for name in subject.traffic}
    if run.limits is None or not stages or None in stages.values():
        return None
    limits = Limits.of_record(run.limits)
    least = sum(limits.least_s(Traffic(**traffic)) for traffic in subject.traffic.values())
    spent = sum(stage.median for stage in stages.values() if stage)
    return least / spent if spent else None


def document(table: Table, run: RunRecord) -> dict[str, Any]:
    """The table as it is written: every row has every column's key."""
    rows = table.rows(run, run.of_table(table.id))
    columns = [*table.columns]
    have = {column.key for column in columns}
    columns += [column for column in STATUS_COLUMNS if column.key not in have]
    keys = [column.key for column in columns]
    return {
        "id": table.id,
        "title": table.title,
        "source": table.source,
        "device": run.environment["device"]["name"],
        "columns": [plain(column) for column in columns],
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
    """Write `tables/<id>.json`, `.md` and `.csv` into the run's folder; returns the document."""
    with blamed_on(rows_file(Path(run.folder)), f"the fields of table {table.id}"):
        made = document(table, run)
        text = markdown(made)
    folder = Path(run.folder) / "tables"
    folder.mkdir(parents=True, exist_ok=True)
    write_json(folder / f"{table.id}.json", made)
    write_file(folder / f"{table.id}.md", text)
    write_file(folder / f"{table.id}.csv", comma_separated(made))
    return made
