"""The Pareto picture: error against time of one case, and the line of those that nobody beats in both."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas

from lodbench.harness.report.amounts import rounded
from lodbench.harness.report.charts.chart_data import FAINT, INK, PAGE, Chart, ChartData, Row, case
from lodbench.harness.report.charts.curves import ticks
from lodbench.harness.report.ratios import LIKE_COUNTS

SIZE = (5.6, 3.5)  # inches: half of a page's first screen
LEAST = 4  # systems that make a picture
LEFT_OUT = ("one_core", "_rounds")  # forms of a subject that is there, for other machines


def front_rows(document: Mapping[str, object], facts: Sequence[str]) -> list[Row]:
    """The rows of the first dataset where subjects leave like numbers of triangles, of its cases the fewest of them.

    Args:
        document: a table's.
        facts: its columns that say which case a row is.
    """
    cases: dict[str, list[Row]] = {}
    rows: Sequence[Row] = document["rows"]  # type: ignore[assignment]
    for row in rows:
        known = all(
            isinstance(row.get(k), int | float) and row[k] > 0
            for k in ("wall_s", "rms_error", "triangles_out")
        )
        kept = row["status"] in ("ok", "noisy") and not row["system"].endswith(LEFT_OUT)
        if known and kept and isinstance(row.get("dataset"), str):
            cases.setdefault(case(row, ["dataset", *facts]), []).append(row)
    alike = {}
    for name, own in cases.items():
        middle = float(np.median([row["triangles_out"] for row in own]))
        alike[name] = [r for r in own if abs(r["triangles_out"] / middle - 1) <= 2 * LIKE_COUNTS]
    found = [own for own in alike.values() if len({row["system"] for row in own}) >= LEAST]
    if not found:
        return []
    first = found[0][0]["dataset"]  # a table has what it is about first
    return min(
        (own for own in found if own[0]["dataset"] == first),
        key=lambda own: float(np.median([row["triangles_out"] for row in own])),
    )


def front(rows: Sequence[Row]) -> list[Row]:
    """Those that no other row beats in both time and error, fastest first."""
    best: list[Row] = []
    for row in sorted(rows, key=lambda row: (row["wall_s"], row["rms_error"])):
        if not best or row["rms_error"] < best[-1]["rms_error"]:
            best.append(row)
    return best


def pareto_front(chart_data: ChartData) -> Chart | None:
    """Error against wall time of one case, with names beside the marks."""
    rows = front_rows(chart_data.document, chart_data.facts)
    if not rows:
        return None
    canvas = Canvas(figsize=SIZE, layout="constrained")
    axes = canvas.subplots()
    axes.loglog()
    low, high = ticks(axes.xaxis, "s", [row["wall_s"] for row in rows], 1.0)
    axes.set_xlim(low, high * (high / low) ** 0.14)  # room for names on the right
    axes.set_ylim(ticks(axes.yaxis, "1", [row["rms_error"] for row in rows], 1.0))
    axes.grid(True)
    best = front(rows)
    axes.plot(
        [row["wall_s"] for row in best], [row["rms_error"] for row in best],
        c=INK, lw=1.0, ds="steps-post", zorder=1,
    )  # fmt: skip
    for row in rows:
        colour, marker, _ = chart_data.style(row["system"])
        noisy = row["status"] == "noisy"
        axes.plot(
            [row["wall_s"]], [row["rms_error"]], ls="", c=colour, marker=marker, ms=6, mew=1.2,
            mfc=PAGE if noisy else colour,
        )  # fmt: skip
    _names(canvas, axes, rows, best)
    axes.set_xlabel("wall time")
    axes.set_ylabel("RMS error / diagonal")
    return Chart(canvas, _caption(rows))


def _caption(rows: Sequence[Row]) -> str:
    counts = sorted(row["triangles_out"] for row in rows)
    out = f"{counts[0]:,} to {counts[-1]:,}" if counts[0] < counts[-1] else f"{counts[0]:,}"
    into = rows[0].get("triangles_in")
    most = max(row["rms_error"] for row in rows) / min(row["rms_error"] for row in rows)
    return (
        f"{rows[0]['dataset']}, {f'{into:,} triangles to ' if into else ''}{out}. Down and to the left is better: "
        "nobody is both faster and nearer than those on the line, in bold. Errors differ by up to "
        f"{rounded(most, 2)} times. Hollow marks are noisy."
    )


def _names(canvas: Canvas, axes: Axes, rows: Sequence[Row], best: Sequence[Row]) -> None:
    """A name beside each mark, where it is free: right, left, above or below of it, else a line away."""
    canvas.draw_without_rendering()
    width, height = (axes.bbox.width * 72 / canvas.dpi, axes.bbox.height * 72 / canvas.dpi)
    to_axes = axes.transData + axes.transAxes.inverted()
    points = {
        id(row): to_axes.transform((row["wall_s"], row["rms_error"])) * (width, height)
        for row in rows
    }
    taken = [(x - 4, y - 4, x + 4, y + 4) for x, y in points.values()]
    for one, other in itertools.pairwise(best):  # the line's steps
        (a, b), (c, d) = points[id(one)], points[id(other)]
        taken += [(a, b - 1, c, b + 1), (c - 1, min(b, d), c + 1, max(b, d))]
    for row in sorted(rows, key=lambda row: row not in best):
        x, y = points[id(row)]
        wide, tall = 4.3 * len(row["system"]) * (1.12 if row in best else 1.0), 9.0
        places = [
            (dx, dy)
            for away in (0, 10, 20, 30, 42)
            for dx, dy in (
                (6, away), (6, -away), (-6 - wide, away), (-6 - wide, -away),
                (-wide / 2, 10 + away), (-wide / 2, -10 - away),
            )
        ]  # fmt: skip
        boxes = [(x + dx, y + dy - tall / 2, x + dx + wide, y + dy + tall / 2) for dx, dy in places]
        chosen = min(
            range(len(boxes)),
            key=lambda i: (_covered(boxes[i], taken, width, height), i),
        )
        taken.append(boxes[chosen])
        dx, dy = places[chosen]
        far = abs(dy) > 12
        axes.annotate(
            row["system"], (row["wall_s"], row["rms_error"]), (dx, dy), textcoords="offset points",
            size=7.5, va="center", weight="bold" if row in best else "normal",
            arrowprops={"arrowstyle": "-", "color": FAINT, "lw": 0.8, "shrinkA": 0, "shrinkB": 3}
            if far else None,
        )  # fmt: skip


def _covered(
    box: tuple[float, ...], taken: Sequence[tuple[float, ...]], width: float, height: float
) -> float:
    """How much of a name's box lies on others or outside of the axes, square points."""
    left, low, right, top = box
    area = 0.0
    for a, b, c, d in taken:
        area += max(min(right, c) - max(left, a), 0) * max(min(top, d) - max(low, b), 0)
    inside = max(min(right, width) - max(left, 0), 0) * max(min(top, height) - max(low, 0), 0)
    return area + 3 * ((right - left) * (top - low) - inside)
