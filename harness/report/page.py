"""One self-contained HTML file of a run: tables, figures, where it was measured, how to do it again."""

from __future__ import annotations

import base64
import re
import shlex
from collections.abc import Iterator, Mapping, Sequence, Sized
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

from lodbench.datasets_gen.files import write_file
from lodbench.harness.record.foreign import PICTURE_FIELDS, blamed_on, read_json
from lodbench.harness.record.record import RUN, RunRecord, read_run
from lodbench.harness.report import plots, statistics
from lodbench.harness.report.amounts import amount
from lodbench.harness.report.charts import ChartData
from lodbench.harness.report.charts.chart_data import FAINT, INK, PAGE, PALETTE, WARNING
from lodbench.harness.report.table_view import columns, headlines, lines

NAME = "report.html"
TEMPLATE = Path(__file__).with_name("page.html")
LEADS = ("fps", "time")  # the first of these that was drawn stands before its table
THEME = {  # a drawing's colours follow the page's; the first of the palette is too dark for a dark page
    INK: "var(--ink)", FAINT: "var(--faint)", PAGE: "var(--page)", WARNING: "var(--warn)",
    PALETTE[0]: "var(--first)",
}  # fmt: skip
IMAGES = {".png": "image/png", ".jpg": "image/jpeg", ".jpeg": "image/jpeg", ".webp": "image/webp"}


@dataclass(frozen=True)
class _Drawn:
    title: str
    caption: str
    kind: str
    svg: Markup


def inline(svg: str, name: str, label: str) -> Markup:
    """An SVG file's drawing for use within a page: own ids, the page's colours, shorter numbers, a name.

    Args:
        svg: the file's text, as matplotlib writes it.
        name: what its ids begin with, unique in the page.
        label: what it shows, for those who cannot see it.
    """
    text = svg[svg.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.S)
    text = re.sub(r'\bid="', f'id="{name}-', text)
    text = re.sub(r'((?:xlink:)?href=")#', rf"\1#{name}-", text)
    text = re.sub(r"url\(#", f"url(#{name}-", text)
    text = re.sub(
        r'\b(?:d|x|y|width|height|transform)="[^"]*"',
        lambda found: re.sub(r"(\d\.\d\d)\d+", r"\1", found[0]),
        text,
    )
    for colour, variable in THEME.items():
        text = text.replace(colour, variable)
    text = re.sub(r"<!--.*?-->\s*", "", text, flags=re.S)
    title = Markup.escape(label)
    head, rest = text.split(">", 1)
    return Markup(f'{head} role="img" aria-label="{title}">{rest}')  # our own drawing


def _figures(folder: Path, run: RunRecord) -> dict[str, list[_Drawn]]:
    found: dict[str, list[_Drawn]] = {}
    for figure in plots.write_figures(folder, run):
        name = f"{figure.table}-{figure.kind}"
        svg = inline(figure.svg.read_text("utf-8"), name, f"{figure.title}: {figure.caption}")
        drawn = _Drawn(figure.title, figure.caption, figure.kind, svg)
        found.setdefault(figure.table, []).append(drawn)
    return found


def _table(made: Mapping[str, Any], run: RunRecord, figures: Sequence[_Drawn]) -> dict[str, Any]:
    shown = columns(made)
    lead = next((f for kind in LEADS for f in figures if f.kind == kind), None)
    facts = ChartData(made, run.of_table(made["id"]), {}).facts
    return {
        "anchor": f"table-{made['id']}",
        "title": made["title"],
        "source": made["source"],
        "device": made["device"],
        "notes": made.get("notes", []),
        "columns": shown,
        "rows": lines(made, facts, shown),
        "shortened": any("extra" in column.css for column in shown),
        "file": f"tables/{made['id']}.csv",
        "published": any(column.key.startswith("published_") for column in shown),
        "headlines": headlines(made),
        "lead": lead,
        "figures": [figure for figure in figures if figure is not lead],
    }


def _entries(values: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Keys and values in words; nested ones are joined."""
    for key, value in values.items():
        unit = "B" if key.endswith("_bytes") else ""
        label = key.removesuffix("_bytes").replace("_", " ")
        if isinstance(value, Mapping):
            inside = ", ".join(f"{name} {text}" for name, text in _entries(value))
            yield label, inside or "none"
        elif isinstance(value, list):
            yield label, ", ".join(amount(item) for item in value) or "none"
        else:
            yield label, amount(value, unit)


def _limits(limits: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for key, value in limits.items():
        label = key.replace("_", " ")
        if isinstance(value, Mapping) and "best" in value:
            best, median = (amount(value[which], value["unit"]) for which in ("best", "median"))
            yield label, f"{best} best, {median} median ({value['subject']})"
        elif not isinstance(value, Mapping | list):
            yield label, amount(value, "B" if key.endswith("_bytes") else "")


def _environment(run: RunRecord) -> list[tuple[str, list[tuple[str, str]]]]:
    e = run.environment
    device = {k: v for k, v in e["device"].items() if k != "extensions"}
    versions = {name: version or "absent" for name, version in e.get("packages", {}).items()}
    made = {
        "Machine": {**e.get("machine", {}), "started": e["started"]},
        "Device": {**device, "pocl": e.get("pocl"), "llvm": e.get("llvm")},
        "Packages": versions,
        "Variables": e.get("variables", {}),
        "Options": {**e.get("options", {}), "seed": e.get("seed")},
    }
    blocks = [(name, list(_entries(values))) for name, values in made.items() if values]
    if run.limits:
        blocks.insert(2, ("Limits of the device, measured in this run", list(_limits(run.limits))))
    return blocks


def _again(run: RunRecord) -> str:
    """The commands that measure this again, and make this file again."""
    e, options = run.environment, run.environment.get("options", {})
    made = []
    if e["commit"] != "unknown":
        made += [f"git checkout {e['commit']}", "make setup"]
    if isinstance(options.get("sweep"), Mapping):
        made.append(f"lodbench sweep {shlex.quote(str(options['sweep'].get('name', 'FILE')))}.toml")
    else:
        words = ["lodbench reproduce", *run.tables]
        words += ["--quick"] if options.get("quick") else []
        for key in ("samples", "time_budget"):
            if options.get(key) is not None:
                words += [f"--{key.replace('_', '-')} {options[key]}"]
        made.append(" ".join(words))
    made.append(
        f"lodbench report {shlex.quote(run.folder.name)}   # tables, figures and this file, from the records"
    )
    return "\n".join(made)


def _images(folder: Path) -> list[dict[str, str]]:
    """Pictures in the order of their list, with its captions and series; others after them, by name."""
    folder = folder / "images"
    listed = folder / "pictures.json"
    known: dict[str, dict[str, str]] = {}
    if listed.is_file():
        known = {each["file"]: each for each in read_json(listed, PICTURE_FIELDS)}
    order = list(known)
    found = []
    for path in sorted(
        folder.glob("*"),
        key=lambda path: (order.index(path.name) if path.name in known else len(order), path),
    ):
        if path.suffix.lower() in IMAGES:
            data = base64.b64encode(path.read_bytes()).decode()
            kind = IMAGES[path.suffix.lower()]
            about = known.get(path.name, {"caption": path.stem.replace("_", " ")})
            shown = {"name": about["caption"], "series": about.get("series", "")}
            found.append({**shown, "data": f"data:{kind};base64,{data}"})
    return found


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
    figures = _figures(folder, run)
    tables = []
    for made in plots.documents(folder):
        with blamed_on(folder / "tables" / f"{made['id']}.json", "a table to show"):
            tables.append(_table(made, run, figures.get(made["id"], [])))
    counts: dict[str, int] = {}
    for table in tables:
        for row in table["rows"]:
            counts[row.status] = counts.get(row.status, 0) + 1
    images = _images(folder)
    with blamed_on(folder / RUN, "where and how it was measured"):
        text = _page(run, tables, counts, images)
    path = folder / NAME
    write_file(path, text)
    return path


def _page(
    run: RunRecord,
    tables: Sequence[Mapping[str, Any]],
    counts: Mapping[str, int],
    images: Sequence[Mapping[str, str]],
) -> str:
    """The page's text."""
    e = run.environment
    device, machine = e["device"], e.get("machine", {})
    cpu = device["kind"] == "cpu"
    name = (machine.get("cpu") if cpu else None) or device["name"]
    subjects = {name for group in run.groups for name in group.subjects}
    datasets = {group.dataset for group in run.groups}
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    return environment.from_string(TEMPLATE.read_text("utf-8")).render(
        title=f"Level of detail on {name}",
        lead=f"{_several(subjects, 'subject')} on {_several(datasets, 'dataset')} in {_several(tables, 'table')}: "
        f"time, memory, error and topology of mesh refinement and simplification, measured with OpenCL "
        f"({device['platform']}) on {name}, "
        f"{_several(range(device.get('compute_units') or 0), 'compute unit')}.",
        emulated="The shader stages of the papers run here as OpenCL kernels on a CPU, not on a graphics card: compare "
        "ratios and growth with published values, not frames per second."
        if cpu
        else "",
        started=e["started"],
        commit=e["commit"],
        dirty=e.get("dirty"),
        statuses=[
            (s, counts[s]) for s in ("ok", "noisy", "skipped", "published", "failed") if s in counts
        ],
        tables=tables,
        series=[list(some) for _, some in groupby(images, key=lambda image: image["series"])],
        noise=_noise(),
        environment=_environment(run),
        again=_again(run),
    )
