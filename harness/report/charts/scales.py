"""What grows with a machine or a file: projected time and its stages over cores, memory and rate over a file's size."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, NullLocator

from lodbench.harness.report.charts.chart_data import (
    INK,
    PAGE,
    STAGES,
    WIDTH,
    Chart,
    ChartData,
    Row,
    by,
    hidden,
    legend,
    spoken,
)
from lodbench.harness.report.charts.curves import curve, ticks

DATASETS = 3
_CHAIN, _PASSES = "chain_s", "chain_pass_"


def over_cores(chart_data: ChartData) -> Chart | None:
    """Seconds over cores, measured and projected, and the passes' shares of what is projected."""
    projected = [row for row in chart_data.rows(_CHAIN, "cores") if row.get("how") == "projected"]
    if len({row["cores"] for row in projected}) < 2:
        return None
    measured = [row for row in chart_data.rows("wall_s", "cores") if row.get("how") == "measured"]
    cases = by(projected, lambda row: row["dataset"])
    shown = list(cases)[-DATASETS:]
    canvas = Canvas(figsize=(WIDTH, 5.2), layout="constrained")
    axes = canvas.subplots(2, len(shown), squeeze=False, sharex="col", sharey="row",
                           height_ratios=(3, 2))  # fmt: skip
    ways = list(dict.fromkeys(_way(row) for row in projected))
    times = [row[_CHAIN] for name in shown for row in cases[name]]
    times += [row["wall_s"] for row in measured if row["dataset"] in shown]
    for number, name in enumerate(shown):
        own = [row for row in measured if row["dataset"] == name]
        top, bottom = axes[0, number], axes[1, number]
        top.set_title(name, loc="left", size=7.5)
        top.loglog()
        top.set_ylim(ticks(top.yaxis, "s", times, 0.8))
        top.grid(True)
        for way in ways:
            colour, marker, _ = chart_data.style(way)
            mine = sorted((r for r in cases[name] if _way(r) == way), key=lambda r: r["cores"])
            top.plot([r["cores"] for r in mine], [r[_CHAIN] for r in mine], c=colour, ls="--",
                     marker=marker, mfc=PAGE)  # fmt: skip
            ran = sorted((r for r in own if _way(r) == way), key=lambda r: r["cores"])
            top.plot([r["cores"] for r in ran], [r["wall_s"] for r in ran], c=colour, marker=marker)
        _shares(bottom, cases[name], ways)
        cores = sorted({row["cores"] for row in (*cases[name], *own)})
        bottom.xaxis.set_major_locator(FixedLocator(cores))
        bottom.xaxis.set_minor_locator(NullLocator())
        bottom.set_xticks(cores, [str(n) for n in cores])
        bottom.set_xlabel("cores")
    axes[0, 0].set_ylabel("time of a frame")
    axes[1, 0].set_ylabel("share of the projection, %")
    keys = [Line2D([], [], c=chart_data.style(w)[0], marker=chart_data.style(w)[1]) for w in ways]
    keys += [
        Line2D([], [], c=INK), Line2D([], [], c=INK, ls="--", marker="o", mfc=PAGE),
        *(Line2D([], [], c=STAGES[i], lw=6) for i in range(len(_passes(projected)))),
    ]  # fmt: skip
    names = [*ways, "measured", "a projection", *map(_pass, _passes(projected))]
    canvas.legend(keys, names, loc="outside upper left", ncols=len(names), frameon=False)
    return Chart(
        canvas,
        "A frame's time over cores. Solid: measured; dashed: a projection, the longest chain of work-groups on so many "
        "cores, which is no measurement and leaves out what cores cost each other. Below, the passes of that chain, "
        f"{' left and '.join(ways)} right.{hidden(len(shown), len(cases))}",
    )


def _way(row: Row) -> str:
    return row["system"].partition("_on")[0]


def _passes(rows: Sequence[Row]) -> list[str]:
    return list(dict.fromkeys(key for row in rows for key in row if key.startswith(_PASSES)))


def _pass(key: str) -> str:
    return spoken(key.removeprefix("chain_").removesuffix("_s"))


def _shares(axes: Axes, rows: Sequence[Row], ways: Sequence[str]) -> None:
    """Each way's passes as a bar of a hundred percent beside those of the others, for each number of cores."""
    passes = _passes(rows)
    step = 0.42 / len(ways)
    for place, way in enumerate(ways):
        own = [row for row in rows if _way(row) == way]
        # on an axis of powers: as wide at 64 cores as at 2
        middle = np.array([row["cores"] for row in own]) * 2 ** (
            2 * step * (place - (len(ways) - 1) / 2)
        )
        parts = np.array([[row.get(key) or 0.0 for key in passes] for row in own])
        shares = 100 * parts / np.maximum(parts.sum(axis=1, keepdims=True), 1e-30)
        ends = shares.cumsum(axis=1)
        for i in range(len(passes)):
            axes.bar(middle, shares[:, i], bottom=ends[:, i] - shares[:, i], color=STAGES[i],
                     width=middle * step, lw=0)  # fmt: skip
    axes.set_ylim(0, 100)


def memory_and_rate(chart_data: ChartData) -> Chart | None:
    """The peak of resident memory over the file's triangles with what was allowed, and triangles per second."""
    keys = ("triangles_read", "peak_bytes", "triangles_per_s")
    rows = chart_data.rows(*keys)
    if len({row["triangles_read"] for row in rows}) < 2:
        return None
    canvas = Canvas(figsize=(WIDTH, 3.2), layout="constrained")
    both = canvas.subplots(1, 2)
    limits = [row for row in rows if row.get("memory_limit_bytes")]
    shown = {"peak_bytes": [row["memory_limit_bytes"] for row in limits]}
    names = {"peak_bytes": ("peak of memory", "B"), "triangles_per_s": ("triangles per second", "")}
    for axes, (key, (label, unit)) in zip(both, names.items(), strict=True):
        axes.loglog()
        for own in by(rows, lambda row: f"{row['system']} {row['dataset']}").values():
            system = own[0]["system"]
            curve(axes, chart_data.style(system), own, "triangles_read", key, system)
        values = [row[key] for row in rows] + shown.get(key, [])
        axes.set_xlim(ticks(axes.xaxis, "", [row["triangles_read"] for row in rows], 0.5))
        axes.set_ylim(ticks(axes.yaxis, unit, values, 1.0))
        axes.grid(True)
        axes.set_xlabel("triangles in the file")
        axes.set_ylabel(label)
    both[0].plot(
        [row["triangles_read"] for row in limits], shown["peak_bytes"],
        ls="", marker="_", ms=14, mew=1.6, c=INK, label="allowed",
    )  # fmt: skip
    legend(canvas, [both[0]])
    return Chart(
        canvas,
        "Peak of memory above what the process had before, with what it was allowed, and triangles read per second of "
        "wall time, from a file to a file; each dataset is a line or a point of its own.",
    )
