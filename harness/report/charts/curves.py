"""Curves: time against triangles, error against triangles, error against time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure as Canvas
from matplotlib.ticker import EngFormatter, FuncFormatter, LogLocator, NullFormatter

from lodbench.harness.report.charts.chart_data import (
    PAGE,
    WIDTH,
    Chart,
    ChartData,
    Row,
    Style,
    by,
    case,
    hidden,
    legend,
    spoken,
    varying,
)
from lodbench.harness.report.statistics import log_slope

PANELS = 6
# sizes lie on the axis, so they are no facts that tell two curves apart
SIZES = ("triangles_in", "vertices_in", "coarse_triangles")
NOT_A_PANEL = {*SIZES, "dataset"}


def _panels(
    rows: Sequence[Row], keys: Sequence[str], *, shared: bool
) -> tuple[Canvas, list[tuple[Axes, list[Row]]], int]:
    """One small axes per case of `keys`, those with most rows when there are many, and how many cases there are."""
    cases = by(rows, lambda row: case(row, keys))
    most = sorted(cases, key=lambda name: -len(cases[name]))[:PANELS]
    shown = [name for name in cases if name in most]
    columns = 2 if len(shown) == 4 else min(len(shown), 3)
    lines = -(-len(shown) // columns)
    canvas = Canvas(figsize=(WIDTH, 3.4 if lines == 1 else 0.6 + 2.3 * lines), layout="constrained")
    grid = canvas.subplots(lines, columns, squeeze=False, sharex=shared, sharey=shared).ravel()
    for spare in grid[len(shown) :]:
        spare.set_axis_off()
    for number, (axes, name) in enumerate(zip(grid, shown, strict=False)):
        if len(shown) > 1:
            axes.set_title(name, loc="left")
            # where the last line is not full, the panel above a gap carries the axis
            axes.tick_params(labelbottom=not shared or number + columns >= len(shown))
    return canvas, [(a, cases[n]) for a, n in zip(grid, shown, strict=False)], len(cases)


def ticks(axis: Axis, unit: str, values: list[float], room: float) -> tuple[float, float]:
    """Ticks for a log axis that has `room` (1: all of the canvas), and its limits: some space around the values."""
    low, high = min(values) / 1.4, max(values) * 1.4
    decades = np.log10(high / low) / room
    steps = (1.0,) if decades > 2.5 else (1.0, 3.0) if decades > 1.3 else (1.0, 2.0, 5.0)
    axis.set_major_locator(LogLocator(subs=steps))
    if unit == "1":
        axis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:.0e}".replace("e-0", "e-")))
    else:
        axis.set_major_formatter(EngFormatter(unit, sep=" " if unit else ""))
    axis.set_minor_formatter(NullFormatter())
    return low, high


def _label_ends(axes: Axes, ends: list[tuple[float, float, str, str]]) -> None:
    """A name beside the last point of each line, moved apart where lines end close together."""
    bottom, top = np.log(axes.get_ylim())
    gap = 0.062  # of the axes' height: a line of text
    ends = sorted(ends, key=lambda end: end[1])
    wanted = [(np.log(y) - bottom) / (top - bottom) for _, y, _, _ in ends]
    places = list(wanted)
    for i in range(1, len(places)):
        places[i] = max(places[i], places[i - 1] + gap)
    places[-1] = min(places[-1], max(1.0, wanted[-1]))
    for i in reversed(range(len(places) - 1)):
        places[i] = min(places[i], places[i + 1] - gap)
    for (x, y, text, colour), place in zip(ends, places, strict=True):
        axes.annotate(
            text,
            (x, y),
            (1.03, place),
            textcoords="axes fraction",
            va="center",
            arrowprops={
                "arrowstyle": "-",
                "color": colour,
                "lw": 1.0,
                "shrinkA": 1,
                "relpos": (0, 0.5),
            },
            annotation_clip=False,
        )


def curve(axes: Axes, style: Style, rows: list[Row], x: str, y: str, label: str) -> Row:
    """One system's points, joined through the median of each place; hollow where noisy. Returns the last row."""
    colour, marker, dash = style
    rows = sorted(rows, key=lambda row: row[x])
    places = {row[x]: [other[y] for other in rows if other[x] == row[x]] for row in rows}
    middles = [np.median(found) for found in places.values()]
    axes.plot([*places], middles, c=colour, ls=dash)
    axes.plot(
        [row[x] for row in rows],
        [row[y] for row in rows],
        c=colour,
        marker=marker,
        ls="",
    )
    axes.plot([], [], c=colour, marker=marker, ls=dash, label=label)
    noisy = [row for row in rows if row["status"] == "noisy"]
    axes.plot(
        [row[x] for row in noisy], [row[y] for row in noisy],
        ls="", c=PAGE, marker=marker, ms=3.0, mew=0,
    )  # fmt: skip
    return rows[-1]


def _draw(
    chart_data: ChartData,
    rows: Sequence[Row],
    panel_keys: Sequence[str],
    x: tuple[str, str, str],
    y: tuple[str, str, str],
    *,
    fitted: bool = False,
    shared: bool = True,
) -> tuple[Canvas, str]:
    """Curves of `y` against `x`, each (key, label, unit), in panels; and what the caption adds."""
    canvas, panels, cases = _panels(rows, panel_keys, shared=shared)
    for axes, part in panels:
        visible = [row for _, other in panels for row in other] if shared else part
        axes.loglog()
        room = 1.0 if len(panels) < 2 else 0.75 if len(panels) in (2, 4) else 0.5
        axes.set_xlim(ticks(axes.xaxis, x[2], [row[x[0]] for row in visible], room))
        axes.set_ylim(ticks(axes.yaxis, y[2], [row[y[0]] for row in visible], 1.0))
        axes.grid(True)
        ends = []
        for name, own in by(part, lambda row: row["system"]).items():
            style = chart_data.style(name)
            last = curve(axes, style, own, x[0], y[0], name)
            fit = log_slope([row[x[0]] for row in own], [row[y[0]] for row in own])
            power = f"  n^{fit[0]:.2f}" if fitted and fit and len(own) > 2 else ""
            ends.append((last[x[0]], last[y[0]], name + power, style.colour))
        if len(panels) == 1:
            _label_ends(axes, ends)
    size: dict[str, Any] = {"size": "medium"}
    if len(panels) == 1:
        panels[0][0].set_xlabel(x[1])
        panels[0][0].set_ylabel(y[1])
    else:
        canvas.supxlabel(x[1], **size)
        canvas.supylabel(y[1], **size)
        legend(canvas, [axes for axes, _ in panels])
    return canvas, f" Hollow marks are noisy.{hidden(len(panels), cases)}"


def time_against_triangles(chart_data: ChartData) -> Chart | None:
    """Median wall time against triangles in, else out, else vertices; both logarithmic, with the fitted power."""
    for x in ("triangles_in", "triangles_out", "vertices"):
        rows = chart_data.rows("wall_s", x)
        systems = by(rows, lambda row: row["system"]).values()
        if any(len({row[x] for row in own}) > 1 for own in systems):
            break
    else:
        return None
    keys = [key for key in varying(rows, chart_data.facts) if key not in NOT_A_PANEL]
    if x != "triangles_in":
        # the facts are what makes the size, and a dataset that is one size of many is no panel
        keys = [key for key in varying(rows, (*SIZES, "dataset")) if key == "dataset"]
    label = spoken(x)
    canvas, more = _draw(
        chart_data, rows, keys, (x, label, ""), ("wall_s", "wall time", "s"), fitted=True
    )
    return Chart(
        canvas, f"Median wall time of a frame against {label}; n^p is the fitted power.{more}"
    )


ERROR = ("rms_error", "RMS error / diagonal", "1")


def error_against_triangles(chart_data: ChartData) -> Chart | None:
    """RMS error against triangles left, where a system was asked for more than one count of a dataset."""
    rows = chart_data.rows("triangles_out", "rms_error")
    curves = by(rows, lambda row: f"{row.get('dataset')} {row['system']}").values()
    if not any(len({row["triangles_out"] for row in own}) > 1 for own in curves):
        return None
    canvas, more = _draw(
        chart_data, rows, varying(rows, ["dataset"]), ("triangles_out", "triangles out", ""), ERROR
    )
    return Chart(
        canvas,
        "RMS distance from the input to the result, as a share of the input's diagonal, against triangles left."
        + more,
    )


def error_against_time(chart_data: ChartData) -> Chart | None:
    """RMS error against wall time: down and to the left is better."""
    rows = chart_data.rows("wall_s", "rms_error")
    if len({row["system"] for row in rows}) < 2:
        return None
    keys = varying(rows, ["dataset"])
    canvas, more = _draw(chart_data, rows, keys, ("wall_s", "wall time", "s"), ERROR, shared=False)
    return Chart(
        canvas,
        "RMS distance from the input to the result against wall time: down and to the left is better. "
        f"The table has the triangles left, which may differ.{more}",
    )


def difference_against_segments(chart_data: ChartData) -> Chart | None:
    """RMS difference from the finest pattern against segments, where there are several."""
    rows = chart_data.rows("segments", "rms_difference")
    if len({row["segments"] for row in rows}) < 2:
        return None
    keys = [key for key in varying(rows, chart_data.facts) if key != "segments"]
    difference = ("rms_difference", "RMS difference / diagonal", "1")
    canvas, more = _draw(chart_data, rows, keys, ("segments", "segments", ""), difference)
    return Chart(
        canvas,
        "RMS distance from the surface under the finest pattern, at its vertices' parameters, as a share of the "
        f"input's diagonal, against the segments of the pattern.{more}",
    )


def along_path(chart_data: ChartData) -> Chart | None:
    """Seconds of a frame and triangles drawn at each view of a camera path, one panel each and path."""
    groups = [
        group for group in chart_data.groups if any(s.path_s for s in group.subjects.values())
    ]
    if not groups:
        return None
    canvas = Canvas(figsize=(WIDTH, 1.2 + 2.2 * len(groups)), layout="constrained")
    grid = canvas.subplots(len(groups), 2, squeeze=False, sharex=True)
    for group, (times, drawn) in zip(groups, grid, strict=True):
        for label, subject in group.subjects.items():
            colour, _, dash = chart_data.style(label)
            spread = {step: np.quantile(s, (0.25, 0.5, 0.75)) for step, s in subject.path_s.items()}
            low, middle, high = 1e3 * np.array([spread[step] for step in sorted(spread)]).T
            times.plot(sorted(spread), middle, c=colour, ls=dash, label=label)
            times.fill_between(sorted(spread), low, high, color=colour, alpha=0.25, lw=0)
            counts = {row["step"]: row.get("triangles") or np.nan for row in subject.frames}
            steps = sorted(counts)
            drawn.plot(steps, [counts[step] for step in steps], c=colour, ls=dash, ds="steps-mid")
        times.set_title(str(group.facts.get("path", group.name)), loc="left")
        times.set_ylabel("ms per frame")
        times.set_ylim(bottom=0)
        drawn.set_ylabel("triangles")
        drawn.set_yscale("log")
        drawn.yaxis.set_major_formatter(EngFormatter("", sep=""))
        drawn.yaxis.set_minor_formatter(NullFormatter())
    for axes in grid[-1]:
        axes.set_xlabel("view on the path")
    legend(canvas, [grid[0][0]])
    caption = (
        "Left: a whole frame, median and quartiles of all rounds. Right: what was drawn in it."
    )
    return Chart(canvas, caption)
