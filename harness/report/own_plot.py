"""A plot of one's own: any column of a table over any other, a series for each value of a third.

Points are rows, with the interval of their value where the table has one (the median's for `wall_s`, the bootstrap's
for ratios). A system has the colour, mark and dash that it has in the run's report.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas
from matplotlib.ticker import EngFormatter, NullFormatter

from lodbench.datasets_gen.files import replacing
from lodbench.harness.record.record import read_run
from lodbench.harness.report import derive
from lodbench.harness.report.amounts import amount
from lodbench.harness.report.charts.chart_data import (
    PAGE,
    WIDTH,
    Row,
    Style,
    by,
    legend,
    spoken,
    styles,
    subjects,
    varying,
)
from lodbench.harness.report.charts.curves import SIZES, ticks
from lodbench.harness.report.plots import RESOLUTION, look
from lodbench.harness.report.rows import table_rows
from lodbench.kernels.parameters import closest

FORMATS = (".png", ".svg", ".pdf")
LOGS = ("x", "y", "xy")


def write_plot(
    run: Path,
    table: str | None,
    x: str,
    y: str,
    series: str,
    out: Path,
    log: str = "",
    keep: re.Pattern[str] | None = None,
) -> str:
    """Draw column `y` of a table over column `x`, and say in a sentence what is drawn.

    Args:
        run: a run's folder.
        table: its table; None where it has one only.
        x: the key of a column; one of text or lists is an axis of names.
        y: the key of a column of numbers.
        series: the key of a column, with a colour for each of its values.
        out: the file, .png, .svg or .pdf; the same bytes each time.
        log: the axes that are logarithmic: x, y or xy.
        keep: only rows in whose dataset, system and facts, as `key=value`, it is found.

    Returns:
        How many rows are drawn, and how many have no value or, on a logarithmic axis, none above 0.

    Raises:
        ValueError: no such table, column, axis or format; or no row to draw.
        OSError: the file cannot be written.
    """
    if out.suffix.lower() not in FORMATS:
        raise ValueError(f"out: expected a name in {', '.join(FORMATS)}, got {out}")
    if log not in ("", *LOGS):
        raise ValueError(f"log: expected one of {', '.join(LOGS)}, got {log!r}")
    found = read_run(run)
    tables = {one.id: one for one in derive.tables_of(found)}
    if table is None and len(tables) == 1:
        table = next(iter(tables))
    if table not in tables:
        raise ValueError(closest("table", table or "", tables))
    rows = table_rows(tables[table], found)
    facts = {key for group in found.of_table(table) for key in group.facts}
    if keep is not None:
        rows = [row for row in rows if keep.search(_words(row, sorted(facts)))]
    names = {column.key: column for column in tables[table].columns}
    known = {key for row in rows for key, value in row.items() if value is not None}
    for option, key in (("x", x), ("y", y), ("by", series)):
        if key not in known:
            raise ValueError(closest(option, key, known))
    drawn = [row for row in rows if _has(row, x, y, log) and row["status"] != "failed"]
    if not drawn:
        wanted = "above 0 " if log else ""
        raise ValueError(f"y: expected numbers {wanted}under {y} and values under {x}, got none")
    shared = styles(subjects(found))[table]
    if series != "system":
        shared = styles({table: {(name := amount(row.get(series))): name for row in drawn}})[table]
    labels = {key: names[key].label if key in names else spoken(key) for key in (x, y)}
    units = {key: names[key].unit if key in names else _unit(key) for key in (x, y)}
    with look():
        canvas = Canvas(figsize=(WIDTH, 4.2), layout="constrained")
        axes = canvas.subplots()
        _scale(axes, drawn, x, y, log, units)
        # what a case is given puts points of several datasets on one line; what came out has a line for each
        apart = facts - {x, y, series, "dataset", *SIZES} if x in {*facts, *SIZES} else {"dataset"}
        other = varying(drawn, sorted(apart - {x, series}))
        for name, own in by(drawn, lambda row: amount(row.get(series))).items():
            for number, line in enumerate(
                by(own, lambda row: str([row.get(k) for k in other])).values()
            ):
                _line(axes, shared[name], line, x, y, name if not number else None)
        axes.grid(True)
        axes.set_xlabel(labels[x])
        axes.set_ylabel(labels[y])
        legend(canvas, [axes])
        with replacing(out) as stream:
            kind = out.suffix.lower()[1:]
            canvas.savefig(
                stream, format=kind, dpi=RESOLUTION, facecolor=PAGE, metadata=_nobody(kind)
            )
    left = len(rows) - len(drawn)
    return f"{len(drawn)} rows of {table}" + (f"; {left} have nothing to draw" if left else "")


def _nobody(kind: str) -> dict[str, Any]:
    """No date and no program, which would differ from one time to the next."""
    words = {
        "png": ("Software",),
        "svg": ("Date", "Creator"),
        "pdf": ("CreationDate", "Producer", "Creator"),
    }
    return dict.fromkeys(words[kind])


def _words(row: Row, facts: Sequence[str]) -> str:
    named = [str(row.get("dataset") or ""), str(row["system"])]
    return " ".join([*named, *(f"{key}={amount(row[key])}" for key in facts if key in row)])


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _has(row: Row, x: str, y: str, log: str) -> bool:
    """May the row be drawn?"""
    if row.get(x) in (None, "") or not _number(row.get(y)) or ("y" in log and row[y] <= 0):
        return False
    return "x" not in log or (_number(row[x]) and row[x] > 0)


def _unit(key: str) -> str:
    return "s" if key.endswith("_s") else "B" if key.endswith("_bytes") else ""


def _at(value: Any) -> Any:
    return value if _number(value) else amount(value)


def _scale(
    axes: Axes, rows: Sequence[Row], x: str, y: str, log: str, units: Mapping[str, str]
) -> None:
    """Logarithmic axes where they are asked for, with ticks in the columns' units."""
    for key, axis, limits, setter in (
        (x, axes.xaxis, axes.set_xlim, axes.set_xscale),
        (y, axes.yaxis, axes.set_ylim, axes.set_yscale),
    ):
        if not all(_number(row[key]) for row in rows):
            axis.set_tick_params(rotation=20)
            for text in axis.get_ticklabels():
                text.set_horizontalalignment("right")
            continue
        if axis.axis_name in log:
            setter("log")
            ends = [
                row[key + end] for row in rows for end in ("_low", "_high") if row.get(key + end)
            ]
            limits(ticks(axis, units[key], [row[key] for row in rows] + ends, 1.0))
        else:
            unit = units[key] if units[key] in ("s", "B") else ""
            axis.set_major_formatter(EngFormatter(unit, sep=" " if unit else ""))
            axis.set_minor_formatter(NullFormatter())


def _line(axes: Axes, style: Style, rows: Sequence[Row], x: str, y: str, label: str | None) -> None:
    """Points with their intervals, joined through the median of each place; hollow where noisy."""
    colour, marker, dash = style
    if all(_number(row[x]) for row in rows):
        rows = sorted(rows, key=lambda row: row[x])
        places = by(rows, lambda row: row[x])
        middles = [np.median([row[y] for row in own]) for own in places.values()]
        axes.plot([*places], middles, c=colour, ls=dash, lw=1.2)
    at = [_at(row[x]) for row in rows]
    values = [row[y] for row in rows]
    axes.plot(at, values, c=colour, marker=marker, ls="")
    if label:
        axes.plot([], [], c=colour, marker=marker, ls=dash, label=label)
    for row, place in zip(rows, at, strict=True):
        low, high = row.get(f"{y}_low"), row.get(f"{y}_high")
        if low is not None and high is not None:
            axes.plot([place, place], [low, high], c=colour, lw=1.0, marker="_", ms=5)
        if row["status"] == "noisy":
            axes.plot([place], [row[y]], ls="", c=PAGE, marker=marker, ms=3.0, mew=0)
