"""A run's figures, drawn from its tables and samples alone: SVG and PNG, the same bytes each time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib

from lodbench.datasets_gen.files import replacing
from lodbench.harness.measure.limits import Limits
from lodbench.harness.record.foreign import blamed_on, check_table, read_json
from lodbench.harness.record.record import RunRecord, read_run
from lodbench.harness.report.charts import CHARTS, ChartData, styles
from lodbench.harness.report.charts.chart_data import FAINT, INK, PAGE, subjects

RESOLUTION = 150  # dots per inch of the PNG files


@dataclass(frozen=True)
class Figure:
    """A drawn figure: the table it belongs to, its kind, the words around it, and its two files."""

    table: str
    kind: str
    title: str
    caption: str
    svg: Path
    png: Path


@contextmanager
def look() -> Iterator[None]:
    """The look of all figures; set here and nowhere on import."""
    settings: dict[Any, Any] = {
        "font.family": "sans-serif",
        "font.sans-serif": ["DejaVu Sans", "Verdana"],
        "font.size": 8.5,
        "axes.titlesize": 8.5,
        "axes.labelsize": 8.5,
        "axes.titleweight": "bold",
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.edgecolor": FAINT,
        "axes.labelcolor": INK,
        "axes.axisbelow": True,
        "axes.grid.axis": "both",
        "text.color": INK,
        "xtick.color": INK,
        "ytick.color": INK,
        "xtick.major.size": 3,
        "xtick.minor.size": 0,
        "ytick.major.size": 3,
        "ytick.minor.size": 0,
        "grid.color": FAINT,
        "grid.linewidth": 0.6,
        "lines.linewidth": 1.5,
        "lines.markersize": 4.5,
        "hatch.linewidth": 0.8,
        "legend.fontsize": 8.5,
        "svg.fonttype": "none",
        "svg.hashsalt": "lodbench",
        "path.simplify": False,
        "text.parse_math": False,  # names are text, whatever is in them
    }
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(settings)
        yield


def documents(folder: Path) -> list[dict[str, Any]]:
    """The tables of a run as they were written, in the order of the record, the rest by name.

    Raises:
        ValueError: a table's file is not one.
    """
    found = {}
    for path in sorted((Path(folder) / "tables").glob("*.json")):
        made = read_json(path, {})
        check_table(made, str(path))
        if made["id"] != path.stem:
            raise ValueError(f"{path}: id: expected {path.stem}, got {made['id']}")
        found[made["id"]] = made
    return list(found.values())


def write_figures(folder: Path, run: RunRecord | None = None) -> list[Figure]:
    """Draw whatever each table of the run has the data for, into `figures/<table>-<kind>.svg` and `.png`.

    Args:
        folder: a run's folder, with its tables written.
        run: its record, when it was read already.

    Raises:
        ValueError: not a run's folder.
    """
    folder = Path(folder)
    run = run or read_run(folder)
    tables = documents(folder)
    shared = styles(_subjects(tables, run))
    limits = Limits.of_record(run.limits) if run.limits else None
    figures = []
    for made in tables:
        chart_data = ChartData(made, run.of_table(made["id"]), shared[made["id"]], limits)
        with blamed_on(folder / "tables" / f"{made['id']}.json", "what can be drawn"):
            figures += _draw(folder / "figures", made, chart_data)
    return figures


def _subjects(tables: Sequence[Mapping[str, Any]], run: RunRecord) -> dict[str, dict[str, str]]:
    """Every subject of each table, with its system; a row that nobody measured is its own."""
    measured = subjects(run)
    return {
        made["id"]: measured.get(made["id"], {})
        | {
            row["system"]: row["system"]
            for row in made["rows"]
            if row["system"] not in measured.get(made["id"], {})
        }
        for made in tables
    }


def _draw(folder: Path, made: Mapping[str, Any], chart_data: ChartData) -> Iterator[Figure]:
    for kind, (title, draw) in CHARTS.items():
        with look():
            chart = draw(chart_data)
            if chart is None:
                continue
            folder.mkdir(parents=True, exist_ok=True)
            svg = folder / f"{made['id']}-{kind}.svg"
            png = svg.with_suffix(".png")
            nobody: dict[str, Any] = {"metadata": {"Date": None, "Creator": None}}
            with replacing(svg) as stream:
                chart.canvas.savefig(stream, format="svg", transparent=True, **nobody)
            chart.canvas.figure.set_layout_engine(
                "none"
            )  # all stands where it is to stand: that took a third
            nobody = {"metadata": {"Software": None}}
            with replacing(png) as stream:
                chart.canvas.savefig(stream, format="png", dpi=RESOLUTION, facecolor=PAGE, **nobody)
        yield Figure(made["id"], kind, title, chart.caption, svg, png)
