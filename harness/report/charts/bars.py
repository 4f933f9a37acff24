"""Horizontal lines in groups, one group per case and one line per subject: bars, stages, samples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas
from matplotlib.ticker import EngFormatter, NullFormatter

from lodbench.harness.measure.timing import SAMPLES
from lodbench.harness.record.record import GroupRecord, SubjectRecord
from lodbench.harness.report.amounts import amount
from lodbench.harness.report.charts.chart_data import (
    FAINT,
    INK,
    PAGE,
    WARNING,
    WIDTH,
    Chart,
    ChartData,
    by,
    case,
    hidden,
    varying,
)
from lodbench.harness.report.statistics import noise

LINES = 48  # what fits on a page
DOTS = 24  # samples of one subject that are drawn


@dataclass
class _Lines:
    """Where the lines are: a heading per group, then a line per subject."""

    cases: Mapping[str, Sequence[Any]]
    more: str

    def __post_init__(self) -> None:
        self.heights: list[float] = []
        self.spans: list[tuple[float, float]] = []
        self.headings: list[tuple[float, str]] = []
        self.total = 0.0
        for name, members in self.cases.items():
            if name:
                self.headings.append((self.total, name))
                self.total += 1.0
            self.heights += [self.total + i for i in range(len(members))]
            self.spans.append((self.total - 0.5, self.total + len(members) - 0.5))
            self.total += len(members) + 0.45

    @property
    def drawn(self) -> list[Any]:
        return [member for members in self.cases.values() for member in members]

    def axes(self, names: Sequence[str]) -> tuple[Canvas, Axes]:
        canvas = Canvas(figsize=(WIDTH, 0.75 + 0.185 * self.total), layout="constrained")
        axes = canvas.subplots()
        axes.set_ylim(self.total - 0.7, -0.7)
        axes.set_yticks(self.heights, names)
        axes.tick_params(axis="y", length=0)
        axes.spines["left"].set_visible(False)
        for at, text in self.headings:
            axes.annotate(
                text,
                (0, at),
                xycoords=axes.get_yaxis_transform(),
                va="center",
                weight="bold",
                annotation_clip=False,
            )
        return canvas, axes

    def grid(self, axes: Axes) -> None:
        """Grid lines beside the groups only, so that headings stay clear of them."""
        low, high = axes.get_xlim()
        ticks = [x for x in axes.get_xticks() if low <= x <= high]
        for top, bottom in self.spans:
            axes.vlines(ticks, top, bottom, color=FAINT, lw=0.6, zorder=0)


def lines_of(cases: Mapping[str, Sequence[Any]]) -> _Lines:
    """The last cases, usually the largest, that fit on a page, and no more of one than do."""
    kept: list[str] = []
    count = 0
    for name in list(cases)[::-1]:
        count += len(cases[name])
        if kept and count > LINES:
            break
        kept.append(name)
    more = hidden(len(kept), len(cases))
    most = max((len(cases[name]) for name in kept), default=0)
    if most > LINES:
        more += f" {LINES} of {most} subjects are drawn; all are in the table."
    return _Lines({n: cases[n][:LINES] for n in cases if n in kept}, more)


def _bars(chart_data: ChartData, key: str, label: str, caption: str) -> Chart:
    rows = chart_data.rows(key)
    keys = varying(rows, chart_data.facts)
    lines = lines_of(by(rows, lambda row: case(row, keys)))
    drawn = lines.drawn
    canvas, axes = lines.axes([row["system"] for row in drawn])
    unit = chart_data.unit(key)
    values = [row[key] for row in drawn]
    claims = [
        (row[f"published_{key}"], at)
        for row, at in zip(drawn, lines.heights, strict=True)
        if isinstance(row.get(f"published_{key}"), int | float)
    ]
    least = min([*values, *(value for value, _ in claims)])
    axes.set_xscale("log")
    most = max([*values, *(value for value, _ in claims)])
    axes.set_xlim(10 ** np.floor(np.log10(least) - 0.15), most * 1.05)
    axes.xaxis.set_major_formatter(EngFormatter(unit if unit == "B" else "", sep=" "))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.barh(
        lines.heights,
        values,
        height=0.72,
        color=[chart_data.style(row["system"])[0] for row in drawn],
        hatch=["////" if row["status"] == "noisy" else "" for row in drawn],
        edgecolor=PAGE,
        lw=0,
    )
    for row, at in zip(drawn, lines.heights, strict=True):
        axes.annotate(
            amount(row[key], unit), (row[key], at), (4, 0), textcoords="offset points", va="center"
        )
    if claims:
        axes.plot(*zip(*claims, strict=True), ls="", marker="D", c=INK, mfc=PAGE, ms=4.5)
        caption += f" Diamonds: published, on other hardware ({chart_data.document['source']})."
    lines.grid(axes)
    axes.set_xlabel(label)
    noisy = any(row["status"] == "noisy" for row in drawn)
    return Chart(canvas, f"{caption}{' Hatched bars are noisy.' if noisy else ''}{lines.more}")


def frames_per_second(chart_data: ChartData) -> Chart | None:
    """Whole frames per second by case and system, logarithmic; without any, those of the stages before the raster."""
    return _rates(chart_data, "frame_fps", "with raster and shading") or _rates(chart_data, *STAGES)


def stages_per_second(chart_data: ChartData) -> Chart | None:
    """Frames per second without drawing, where whole frames were drawn as well."""
    drawn = {row["system"] for row in chart_data.rows("frame_fps")}
    return _rates(chart_data, *STAGES) if len(drawn) > 1 else None


STAGES = ("stage_fps", "up to and including the geometry stage")


def _rates(chart_data: ChartData, key: str, what: str) -> Chart | None:
    if len({row["system"] for row in chart_data.rows(key)}) < 2:
        return None  # bars compare systems
    return _bars(chart_data, key, f"frames per second ({what})", "From median wall time.")


def footprint(chart_data: ChartData) -> Chart | None:
    """Bytes that must stay in memory to draw the surface, where systems mostly differ by a factor of two."""
    rows = chart_data.rows("stored_bytes")
    keys = varying(rows, chart_data.facts)
    values = [
        [row["stored_bytes"] for row in part]
        for part in by(rows, lambda row: case(row, keys)).values()
    ]
    if not values or np.median([max(part) / min(part) for part in values]) < 2:
        return None
    return _bars(
        chart_data, "stored_bytes", "stored", "Bytes that must stay in memory to draw the surface."
    )


def subjects_of(chart_data: ChartData) -> dict[str, list[tuple[GroupRecord, SubjectRecord]]]:
    """Every subject with samples, by case."""
    facts = [{**group.facts, "dataset": group.dataset} for group in chart_data.groups]
    every = chart_data.facts or list(dict.fromkeys(key for fact in facts for key in fact))
    keys = varying(facts, every) or varying(facts, ["dataset", *facts[0]] if facts else [])
    found: dict[str, list[tuple[GroupRecord, SubjectRecord]]] = {}
    for group, fact in zip(chart_data.groups, facts, strict=True):
        for subject in group.subjects.values():
            if subject.samples:
                found.setdefault(case(fact, keys), []).append((group, subject))
    return found


def _dots(axes: Axes, x: Any, y: Any, size: float, colour: str, length: float) -> None:
    """Dots as the round ends of short lines, one path for all of them: a tenth of the SVG that marks would be."""
    ends = np.stack([x - length / 2, x + length / 2, np.full_like(x, np.nan)], axis=1).ravel()
    axes.plot(ends, np.repeat(y, 3), ls="-", lw=size, c=colour, solid_capstyle="round", snap=False)


def _thinned(values: Any) -> Any:
    """Sorted samples, at most `DOTS` of them, evenly by rank, least and most included."""
    values = np.sort(values)
    if len(values) <= DOTS:
        return values
    return values[np.linspace(0, len(values) - 1, DOTS).round().astype(int)]


def samples(chart_data: ChartData) -> Chart | None:
    """Samples as dots, relative to its subject's median; noisy subjects are marked."""
    lines = lines_of(subjects_of(chart_data))
    drawn: list[tuple[GroupRecord, SubjectRecord]] = lines.drawn
    if not drawn:
        return None
    marks = [
        noise([*s.wall_s.values()], [row["cpu_s"] for row in s.samples], group.others)
        for group, s in drawn
    ]
    names = [
        f"{s.label}{' (noisy)' if mark else ''}" for (_, s), mark in zip(drawn, marks, strict=True)
    ]
    canvas, axes = lines.axes(names)
    for tick, mark in zip(axes.get_yticklabels(), marks, strict=True):
        tick.set_color(WARNING if mark else INK)
    wall = [np.array([*s.wall_s.values()]) for _, s in drawn]
    away = [100 * (_thinned(w) / np.median(w) - 1) for w in wall]
    furthest = float(np.percentile(np.abs(np.concatenate(away)), 95))
    edge = next((limit for limit in (5, 10, 20, 40) if furthest < limit), 80)
    axes.set_xlim(-1.04 * edge, 1.04 * edge)
    lines.grid(axes)
    for top, bottom in lines.spans:
        axes.vlines(0, top, bottom, color=INK, lw=0.7, zorder=1)
    for (_, subject), at, mark, x, w in zip(drawn, lines.heights, marks, away, wall, strict=True):
        y = at + 0.5 * (
            (np.arange(len(x)) * 0.618034) % 1 - 0.5
        )  # spread evenly, the same each time
        colour = chart_data.style(subject.label)[0]
        inside = np.abs(x) <= edge
        _dots(axes, x[inside], y[inside], 3.0, colour, 0.004 * edge)
        if mark:
            _dots(axes, x[inside], y[inside], 1.6, PAGE, 0.004 * edge)
        for side, marker in ((-1, "<"), (1, ">")):
            beyond = y[side * x > edge]
            axes.plot(
                np.full(len(beyond), side * edge), beyond, ls="", c=colour, ms=4, marker=marker
            )
        few = " (few)" if len(w) < SAMPLES else ""
        axes.annotate(
            f"{amount(float(np.median(w)), 's')}, n = {len(w)}{few}",
            (1.07 * edge, at),
            va="center",
            annotation_clip=False,
        )
    axes.set_xlabel("wall time of each sample against the subject's median, %")
    return Chart(
        canvas,
        f"Counted samples, at most {DOTS} of each, evenly by rank, against their subject's median, which stands to the "
        f"right; triangles lie beyond the axis. Hollow dots: the subject is noisy.{lines.more}",
    )
