"""A table's rows as a report shows them: one unit per column, quartiles and intervals beside their value."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lodbench.harness.report.amounts import amount, rounded

Document = Mapping[str, Any]

RANGES = (("_low", "_high"), ("_lower", "_upper"))
SCALES = {
    "s": ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs")),
    "B": ((1e9, "GB"), (1e6, "MB"), (1e3, "kB"), (1.0, "B")),
    "1": ((0.01, "1"), (3e-5, "×10⁻³"), (0.0, "×10⁻⁶")),
}
MOST_ON_PAPER = 14  # columns of a landscape page
LESS = (  # what paper can do without, in this order; the screen and the files have all of it
    "wall_s_min", "wall_error", "samples", "frames", "frame_s", "vertices_out", "rms_error_back", "flipped_triangles",
    "stored_bytes", "first_launch_s", "stage_s", "batches", "open_edges", "triangles_per_s", "vertices_per_s",
)  # fmt: skip
FACTORS = {"×10⁻³": 1e-3, "×10⁻⁶": 1e-6}


@dataclass(frozen=True)
class Shown:
    """A column as shown: where its values and their range come from, and the unit they are divided into."""

    key: str
    label: str
    unit: str
    scale: float
    low: str | None
    high: str | None
    css: str


@dataclass(frozen=True)
class Cell:
    """One cell: what is read, what a pointer shows, and what sorting compares."""

    text: str
    css: str = ""
    exact: str = ""
    sort: str = ""
    range: str = ""
    status: bool = False
    why: str = ""


@dataclass(frozen=True)
class Line:
    """One row; `first` opens a case."""

    status: str
    first: bool
    cells: list[Cell]


def _numbers(rows: Sequence[Mapping[str, Any]], key: str) -> list[float]:
    values = (row.get(key) for row in rows)
    return [abs(v) for v in values if isinstance(v, int | float) and not isinstance(v, bool) and v]


def columns(document: Document) -> list[Shown]:
    """The columns to show: status first, none without a value, low and high ends within their value's cell."""
    rows = document["rows"]
    known = {column["key"]: column for column in document["columns"]}
    inside, found = set(), []
    for key in known:
        for ends in RANGES:
            low, high = (key + end for end in ends)
            if low in known and high in known:
                inside |= {low, high}
    for key in sorted(known, key=lambda key: key != "status"):
        if (
            key in inside
            or key == "reason"
            or not any(row.get(key) not in (None, "") for row in rows)
        ):
            continue
        column = known[key]
        unit, scale = column["unit"], 1.0
        numbers = _numbers(rows, key)
        if unit in SCALES and numbers:
            middle = float(np.median(numbers))
            least, unit = next((s for s in SCALES[unit] if middle >= s[0]), SCALES[unit][-1])
            scale = FACTORS.get(unit, 1.0 if unit == "1" else least)
        classes = {
            "text": not numbers,
            "name": key == "system",
            "claim": key.startswith("published_"),
        }
        css = " ".join(name for name, holds in classes.items() if holds)
        ends = next(
            ([key + end for end in ends] for ends in RANGES if key + ends[0] in inside),
            [None, None],
        )
        found.append(
            Shown(key, column["label"], "" if unit == "1" else unit, scale, ends[0], ends[1], css)
        )
    return _for_paper(found, rows)


def _for_paper(found: list[Shown], rows: Sequence[Mapping[str, Any]]) -> list[Shown]:
    """Mark columns as `extra`, the emptiest first, until the rest fits a page."""
    empty = {c.key: sum(row.get(c.key) is None for row in rows) / len(rows) for c in found}
    sparse = sorted((c.key for c in found if empty[c.key] > 0.4), key=lambda key: -empty[key])
    listed = [c.key for c in found]
    order = [*sparse, *(key for key in LESS if key in listed and key not in sparse)]
    extra = set(order[: max(len(found) - MOST_ON_PAPER, 0)])
    return [replace(c, css=f"{c.css} extra".strip()) if c.key in extra else c for c in found]


def _cell(row: Mapping[str, Any], column: Shown) -> Cell:
    value = row.get(column.key)
    if value is None or value == "":
        return Cell("–", column.css)
    if column.key == "status":
        return Cell(str(value), column.css, sort=str(value), status=True)
    if column.key == "system":
        return Cell(str(value), column.css, sort=str(value), why=row.get("reason") or "")
    if isinstance(value, bool) or not isinstance(value, int | float):
        return Cell(amount(value), column.css, sort=amount(value))
    within = ""
    ends = [row[end] for end in (column.low, column.high) if end and row.get(end) is not None]
    if len(ends) == 2:
        low, high = (rounded(end / column.scale, 3) for end in ends)
        within = f"[{low}, {high}]"
    whole = isinstance(value, int) and column.scale == 1
    text = f"{value:,}" if whole else rounded(value / column.scale)
    return Cell(text, column.css, exact=repr(value), sort=repr(value), range=within)


def lines(document: Document, facts: Sequence[str], shown: Sequence[Shown]) -> list[Line]:
    """Every row; `facts` are the columns that say which case it is."""
    found, before = [], None
    for row in document["rows"]:
        case = [row.get(key) for key in facts]
        cells = [_cell(row, column) for column in shown]
        found.append(Line(row["status"], case != before and before is not None, cells))
        before = case
    return found


@dataclass(frozen=True)
class Headline:
    """One sentence of a table, with its figure in the middle."""

    before: str
    value: str
    after: str


MOST = 6


def headlines(document: Document) -> list[Headline]:
    """How fast the table's subject is against each baseline: the median and range over verified cases.

    The subject is the first system that is no baseline itself and has ratios to this one.
    """
    keys = [
        column["key"]
        for column in document["columns"]
        if column["key"].startswith("ratio_to_") and not column["key"].endswith(("_low", "_high"))
    ]
    baselines = [key.removeprefix("ratio_to_") for key in keys]
    found = []
    for key, baseline in zip(keys, baselines, strict=True):
        ours = [r for r in document["rows"] if r["system"] not in baselines and r.get(key)]
        subject = ours[0]["system"] if ours else None
        ratios = [r[key] for r in ours if r["system"] == subject]
        if not ratios:
            continue
        several = (
            f"median of {len(ratios)} cases, {rounded(min(ratios), 3)} to {rounded(max(ratios), 3)}"
        )
        found.append(
            Headline(
                f"{subject} is",
                f"{rounded(float(np.median(ratios)), 3)} times",
                f"as fast as {baseline} ({several if len(ratios) > 1 else 'one case'}).",
            )
        )
    return found[:MOST]
