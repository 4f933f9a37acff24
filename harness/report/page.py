"""One self-contained HTML file of a run: verdicts first, then tables and figures, then where it was measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Sized
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

from lodbench.datasets_gen.files import write_file
from lodbench.harness.record.foreign import blamed_on
from lodbench.harness.record.record import RUN, RunRecord, read_run
from lodbench.harness.report import claims, embedded, plots, provenance, statistics
from lodbench.harness.report.amounts import amount
from lodbench.harness.report.charts import ChartData
from lodbench.harness.report.derive import brief_keys
from lodbench.harness.report.drawings import Drawings
from lodbench.harness.report.embedded import Embedded
from lodbench.harness.report.table_view import MOST, columns, headlines, lines

NAME = "report.html"
TEMPLATE = "page.html"
# the first of these that was drawn stands before its table, the others after it
LEADS = ("path", "error-time", "front", "fps", "time", "difference", "memory", "cores", "error")
FRONT, FIRST_TABLE = (
    "front",
    "pareto",
)  # the picture of the first screen, and the table it is of where there are several
ON_FIRST_SCREEN = 10  # pictures of rivals


@dataclass(frozen=True)
class _Drawn:
    title: str
    caption: str
    kind: str
    svg: Markup


def _figures(folder: Path, run: RunRecord, drawings: Drawings) -> dict[str, list[_Drawn]]:
    found: dict[str, list[_Drawn]] = {}
    for figure in plots.write_figures(folder, run):
        label = f"{figure.title}: {figure.caption}"
        svg = drawings.inline(figure.svg.read_text("utf-8"), label)
        drawn = _Drawn(figure.title, figure.caption, figure.kind, svg)
        found.setdefault(figure.table, []).append(drawn)
    return found


def _take_front(figures: Mapping[str, list[_Drawn]]) -> tuple[str, _Drawn | None]:
    """The Pareto picture of the first screen, taken from its table, and the table's id."""
    for table in sorted(figures, key=lambda name: name != FIRST_TABLE):
        for figure in figures[table]:
            if figure.kind == FRONT:
                figures[table].remove(figure)
                return table, figure
    return "", None


def _table(
    made: Mapping[str, Any],
    run: RunRecord,
    figures: Sequence[_Drawn],
    pictures: Sequence[Embedded],
    brief: Sequence[str],
) -> dict[str, Any]:
    facts = ChartData(made, run.of_table(made["id"]), {}).facts
    shown = columns(made, brief, facts)
    lead = next((f for kind in LEADS for f in figures if f.kind == kind), None)
    strips = embedded.strips(pictures)
    if lead is None and not strips:
        lead = next(iter(figures), None)
    return {
        "anchor": f"table-{made['id']}",
        "title": made["title"],
        "source": made["source"],
        "device": made["device"],
        "notes": made.get("notes", []),
        "columns": shown,
        "rows": lines(made, facts, shown),
        "file": f"tables/{made['id']}.csv",
        "published": any(column.key.startswith("published_") for column in shown),
        "headlines": headlines(made, facts),
        "lead": lead,
        "strips": [(strip, embedded.is_slider(strip)) for strip in strips],
        "figures": [figure for figure in figures if figure is not lead],
    }


def _noise() -> str:
    return (
        f"the median may be off by more than {statistics.NOISY:.0%}, and believing it costs what its reason says: by "
        "chance, as far as its 95% interval reaches; or, where other processes took more than "
        f"{statistics.NOISY_OTHERS:.0%} of the machine or a quarter of the samples got less than "
        f"{statistics.NOISY_CPU:.0%} of the usual CPU time, as much as it took longer than the least "
        f"sample; where others took more than {statistics.MOST_OTHERS:.0%}, nobody knows."
    ).replace("%", " %")


def _several(things: Sized, name: str) -> str:
    return f"{amount(len(things))} {name}{'' if len(things) == 1 else 's'}"


def write_report(folder: Path) -> Path:
    """Write the run's figures and `report.html` from its record and its tables; returns the file.

    No network is needed to read it: styles, script, figures and pictures are inside.

    Raises:
        ValueError: not a run's folder.
    """
    folder = Path(folder)
    run = read_run(folder)
    drawings = Drawings()
    figures = _figures(folder, run, drawings)
    front_table, front = _take_front(figures)
    pictures = embedded.pictures(folder)
    rivals = embedded.rivals(pictures)[:ON_FIRST_SCREEN]
    rest = [picture for picture in pictures if picture not in rivals]
    brief = brief_keys(run)
    tables = []
    for made in plots.documents(folder):
        name = made["id"]
        own = [picture for picture in rest if picture.table == name]
        rest = [picture for picture in rest if picture.table != name]
        with blamed_on(folder / "tables" / f"{name}.json", "a table to show"):
            tables.append(_table(made, run, figures.get(name, []), own, brief.get(name, ())))
    with blamed_on(folder / RUN, "where and how it was measured"):
        first = {
            "claims": claims.verdicts(run),
            "front": front,
            "front_table": front_table,
            "rivals": rivals,
        }
        text = _page(run, tables, first, embedded.strips(rest), drawings)
    path = folder / NAME
    write_file(path, text)
    return path


def _page(
    run: RunRecord,
    tables: Sequence[Mapping[str, Any]],
    first: Mapping[str, Any],
    strips: Sequence[list[Embedded]],
    drawings: Drawings,
) -> str:
    """The page's text."""
    e = run.environment
    device, machine = e["device"], e.get("machine", {})
    cpu = device["kind"] == "cpu"
    name = (machine.get("cpu") if cpu else None) or device["name"]
    subjects = {name for group in run.groups for name in group.subjects}
    datasets = {group.dataset for group in run.groups}
    counts: dict[str, int] = {}
    for table in tables:
        for row in table["rows"]:
            counts[row.status] = counts.get(row.status, 0) + 1
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent), autoescape=True,
        undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    return environment.get_template(TEMPLATE).render(
        title=f"Level of detail on {name}",
        lead=f"{_several(subjects, 'subject')} on {_several(datasets, 'dataset')} in {_several(tables, 'table')}, "
        f"measured with OpenCL ({device['platform']}), "
        f"{_several(range(device.get('compute_units') or 0), 'compute unit')}.",
        emulated="Shader stages run here as OpenCL kernels on a CPU, not on a graphics card: compare ratios and growth "
        "with published values, not frames per second."
        if cpu
        else "",
        started=e["started"],
        commit=e["commit"],
        dirty=e.get("dirty"),
        statuses=[
            (s, counts[s]) for s in ("ok", "noisy", "skipped", "published", "failed") if s in counts
        ],
        **_judged(first["claims"]),
        front=first["front"],
        front_table=first["front_table"],
        rivals=first["rivals"],
        tables=tables,
        most=MOST,
        sliders=[strip for strip in strips if embedded.is_slider(strip)],
        strips=[strip for strip in strips if not embedded.is_slider(strip)],
        noise=_noise(),
        environment=provenance.environment(run),
        again=provenance.again(run),
        drawn=drawings.css(),
    )


def _judged(found: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Claims with a verdict, those without, and how many have which."""
    known = [one for one in found if one["verdict"] not in claims.UNJUDGED]
    order = (claims.CONFIRMED, claims.PARTLY, claims.UNDECIDED, claims.REFUTED)
    counts = [(word, sum(one["verdict"] == word for one in known)) for word in order]
    return {
        "claims": found,
        "judged": known,
        "unjudged": [one for one in found if one["verdict"] in claims.UNJUDGED],
        "tally": [(word, count) for word, count in counts if count],
    }
