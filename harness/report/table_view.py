"""A table's rows as a report shows them: one unit per column, quartiles and intervals beside their value."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
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
MOST = 8  # columns that are shown until all are asked for
WANTED = (
    "wall_s",
    "frame_fps",
    "rms_error",
    "rms_difference",
)  # before others, where a table has them
LAST = (  # what a first look can do without
    "wall_s_min", "wall_error", "samples", "frames", "frame_s", "vertices_out", "vertices_in", "rms_error_back",
    "flipped_triangles", "stored_bytes", "first_launch_s", "stage_s", "batches", "open_edges", "triangles_per_s",
    "vertices_per_s", "status",
)  # fmt: skip
FACTORS = {"×10⁻³": 1e-3, "×10⁻⁶": 1e-6}


@dataclass(frozen=True)
class Shown:
    """A column as shown: where its values and their range come from, and the unit they are divided into.

    `css`: "t" for text, "c" for a published value.
    """

    key: str
    label: str
    unit: str
    scale: float
    low: str | None
    high: str | None
    css: str


@dataclass(frozen=True)
class Cell:
    """One cell: what is read, its class, its number where that says more, its range, and why it is as it is."""

    text: str
    css: str = ""
    exact: str = ""
    range: str = ""
    why: str = ""


@dataclass(frozen=True)
class Line:
    """One row; `first` opens a case."""

    status: str
    first: bool
    cells: list[Cell]

    @property
    def css(self) -> str:
        """Its classes; a row that is all right has none."""
        status = "" if self.status == "ok" else f"is-{self.status}"
        return " ".join(filter(None, (status, "first" if self.first else "")))


def _numbers(rows: Sequence[Mapping[str, Any]], key: str) -> list[float]:
    values = (row.get(key) for row in rows)
    return [abs(v) for v in values if isinstance(v, int | float) and not isinstance(v, bool) and v]


def columns(
    document: Document, brief: Sequence[str] = (), facts: Sequence[str] = ()
) -> list[Shown]:
    """The columns to show, the `MOST` that a first look needs before the rest; `system` is the first of all.

    None without a value; low and high ends stand within their value's cell, reasons within the first.

    Args:
        document: a table's.
        brief: keys of the columns that a terminal shows, where the table says so.
        facts: keys of the columns that say which case a row is.
    """
    found = {column.key: column for column in every_column(document)}
    first = _first([*found], document["rows"], brief, facts)
    return [found[key] for key in (*first, *(key for key in found if key not in first))]


def every_column(document: Document) -> list[Shown]:
    """The columns that have a value, in the table's order; low and high ends and reasons are in others' cells."""
    rows = document["rows"]
    known = {column["key"]: column for column in document["columns"]}
    ends = {
        key: (key + low, key + high)
        for key in known
        for low, high in reversed(RANGES)
        if key + low in known and key + high in known
    }
    inside = {end for pair in ends.values() for end in pair} | {"reason"}
    return [
        _shown(column, rows, ends.get(key))
        for key, column in known.items()
        if key not in inside and any(row.get(key) not in (None, "") for row in rows)
    ]


def _shown(
    column: Mapping[str, str], rows: Sequence[Mapping[str, Any]], ends: tuple[str, str] | None
) -> Shown:
    key, unit, scale = column["key"], column["unit"], 1.0
    numbers = _numbers(rows, key)
    if unit in SCALES and numbers:
        middle = float(np.median(numbers))
        least, unit = next((s for s in SCALES[unit] if middle >= s[0]), SCALES[unit][-1])
        scale = FACTORS.get(unit, 1.0 if unit == "1" else least)
    css = " ".join(filter(None, ("" if numbers else "t", "c" * key.startswith("published_"))))
    low, high = ends or (None, None)
    return Shown(key, column["label"], "" if unit == "1" else unit, scale, low, high, css)


def _first(
    keys: Sequence[str],
    rows: Sequence[Mapping[str, Any]],
    brief: Sequence[str],
    facts: Sequence[str],
) -> list[str]:
    """The system, and of the others the most useful, in the table's order; with a speed-up stands an error."""
    varying = [k for k in facts if len({str(row.get(k)) for row in rows}) > 1]
    ratios = [key for key in keys if key.startswith(("ratio_to_", "frame_ratio_to_"))]
    order = dict.fromkeys(
        [
            *(key for key in varying if not brief or key in brief),
            *(key for key in WANTED if key in keys),
            *ratios[:1],
            *brief,
            *sorted(
                (key for key in keys if key not in LAST and (key in varying or key not in facts)),
                key=lambda key: sum(row.get(key) is None for row in rows) > 0.4 * len(rows),
            ),
            *LAST,
        ]
    )
    chosen = [k for k in order if k in keys and k not in ("system", "status")][: MOST - 1]
    return ["system"] * ("system" in keys) + [key for key in keys if key in chosen]


def _cell(row: Mapping[str, Any], column: Shown) -> Cell:
    value = row.get(column.key)
    if value is None or value == "":
        return Cell("–", column.css)
    if column.key == "system":
        return Cell(str(value), column.css, why=row.get("reason") or "")
    if isinstance(value, bool) or not isinstance(value, int | float):
        return Cell(amount(value), column.css)
    within = ""
    ends = [row[end] for end in (column.low, column.high) if end and row.get(end) is not None]
    if len(ends) == 2:
        low, high = (rounded(end / column.scale, 3) for end in ends)
        within = f"[{low}, {high}]"
    whole = isinstance(value, int) and column.scale == 1
    text = f"{value:,}" if whole else rounded(value / column.scale)
    exact = f"{value:.6g}"
    return Cell(text, column.css, "" if exact == text.replace(",", "") else exact, within)


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


SENTENCES = 6
SAME = 5e-3  # by which an error may differ and be called the same


def headlines(document: Document, facts: Sequence[str] = ()) -> list[Headline]:
    """How fast the table's subject is against each baseline, and how near: medians and ranges over verified cases.

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
        ours = [r for r in ours if r["system"] == subject]
        ratios = [r[key] for r in ours]
        if not ratios:
            continue
        several = (
            f"median of {len(ratios)} cases, {rounded(min(ratios), 3)} to {rounded(max(ratios), 3)}"
        )
        ends = [ours[0].get(key + end) for end in ("_low", "_high")]
        if len(ratios) == 1:
            several = "one case"
            if None not in ends:
                several += f", {rounded(ends[0], 3)} to {rounded(ends[1], 3)} in 95 %"
        found.append(
            Headline(
                f"{subject} is",
                f"{rounded(float(np.median(ratios)), 3)} times",
                f"as fast as {baseline} ({several}){_errors(document['rows'], facts, ours, baseline)}.",
            )
        )
    return found[:SENTENCES]


def _errors(
    rows: Sequence[Mapping[str, Any]],
    facts: Sequence[str],
    ours: Sequence[Mapping[str, Any]],
    baseline: str,
) -> str:
    """The RMS error that the speed-up comes with, as a multiple of the baseline's; "" where it is not known of both."""

    def case(row: Mapping[str, Any]) -> tuple[str, ...]:
        return tuple(str(row.get(key)) for key in facts)

    theirs = {case(row): row.get("rms_error") for row in rows if row["system"] == baseline}
    pairs = [(row.get("rms_error"), theirs.get(case(row))) for row in ours]
    shares = [mine / other for mine, other in pairs if mine and other]
    if not shares:
        return ""
    if all(abs(share - 1) < SAME for share in shares):
        return ", with the same RMS error"
    span = f" ({rounded(min(shares), 2)} to {rounded(max(shares), 2)})" if len(shares) > 1 else ""
    return f", with {rounded(float(np.median(shares)), 2)} times its RMS error{span}"
