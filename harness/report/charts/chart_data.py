"""What charts are drawn from, and what they share: a table's rows, its groups, colours, the words for a case."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure as Canvas

from lodbench.harness.measure.limits import Limits
from lodbench.harness.record.record import GroupRecord, RunRecord
from lodbench.harness.report.amounts import amount

Row = Mapping[str, Any]


class Style(NamedTuple):
    """How a subject is drawn: the colour is its system's; mark and dash tell it from the system's other subjects."""

    colour: str
    marker: str
    dash: str


# Okabe & Ito's colours first, told apart by readers who are colour-blind; without yellow and black, lost on a page
PALETTE = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c6d4f", "#7f7f7f",
    "#6a3d9a", "#b2182b", "#7f9a00", "#00828f", "#e7298a", "#1b6e3c", "#a6761d", "#3f51b5",
    "#f4756b", "#40bfa5", "#5d4037", "#9e7bd0", "#a01850", "#546e7a", "#afb42b", "#7b1fa2",
    "#c98a5e", "#2e8bc0", "#94a3b8", "#d4a5c9", "#4b6b00", "#ff8f3f", "#006d77", "#c94c8b",
)  # fmt: skip
MARKERS = "osD^vPX*"
DASHES = ("-", "--", ":", "-.")
SHADES = (0.0, -0.4, 0.4)  # of a system's first, second, third subject: how far to black or white
STAGES = ("#8fa5b8", "#c3cfda", "#a3ae9c", "#d3dacd", "#a99db5", "#d9d2e1", "#bfa99a", "#e3d8cf")
"""Of what is no system, such as the stages of a frame: these greys stand for no system anywhere."""
INK, FAINT, WARNING, PAGE = "#1f2328", "#d0d7de", "#b35900", "#ffffff"
ON_COLOUR = "#111518"  # text on a bar stays dark where the page is

WIDTH = 7.4  # inches: the report's column


@dataclass(frozen=True)
class ChartData:
    """A table's document, the whole groups it was made from, a style per subject, the device's limits."""

    document: Mapping[str, Any]
    groups: Sequence[GroupRecord]
    styles: Mapping[str, Style]
    limits: Limits | None = None

    @property
    def facts(self) -> list[str]:
        """Columns that say which case a row is: the groups' facts, in the table's order."""
        known = {"dataset", *(key for group in self.groups for key in group.facts)}
        keys = [column["key"] for column in self.document["columns"]]
        return [key for key in keys if key in known and key not in ("system", "standin")]

    def rows(self, *keys: str) -> list[Row]:
        """Measured rows that have positive numbers under all of `keys`."""
        return [
            row
            for row in self.document["rows"]
            if row["status"] in ("ok", "noisy")
            and all(isinstance(row.get(k), int | float) and row[k] > 0 for k in keys)
        ]

    def unit(self, key: str) -> str:
        return next((c["unit"] for c in self.document["columns"] if c["key"] == key), "")

    def style(self, system: str) -> Style:
        return self.styles.get(system, Style(PALETTE[7], "o", "-"))


@dataclass(frozen=True)
class Chart:
    """A drawn canvas and the sentence under it."""

    canvas: Canvas
    caption: str


def styles(tables: Mapping[str, Mapping[str, str]]) -> dict[str, dict[str, Style]]:
    """The style of each table's subjects: a colour means one system, and a system has one colour, in all of them.

    Where there are more systems than colours, those of the fewest tables share with one of other tables. Subjects of
    one system differ in shade, mark and dash.

    Args:
        tables: of each, its subjects in their order, and the system of each.
    """
    seen: dict[str, list[str]] = {}  # system -> the tables it is in
    for name, subjects in tables.items():
        for system in dict.fromkeys(subjects.values()):
            seen.setdefault(system, []).append(name)
    colours: dict[str, int] = {}
    for system in sorted(seen, key=lambda system: -len(seen[system])):
        near = [
            colours[other] for other in colours if not set(seen[other]).isdisjoint(seen[system])
        ]
        used = [*colours.values()]
        colours[system] = min(range(len(PALETTE)), key=lambda i: (near.count(i), used.count(i), i))
    # system -> its subjects, all tables' together; the one of its own name before the others
    own = {
        system: [system] * any(system in tables[name] for name in seen[system]) for system in seen
    }
    found: dict[str, dict[str, Style]] = {}
    for name, subjects in tables.items():
        for label, system in subjects.items():
            labels = own[system]
            labels += [label] if label not in labels else []
            found.setdefault(name, {})[label] = _style(colours[system], labels.index(label))
    return found


def _style(colour: int, number: int) -> Style:
    """The style of a system's subject of this number."""
    toward = SHADES[number % len(SHADES)]
    end = float(toward > 0)
    r, g, b = ((1 - abs(toward)) * part + abs(toward) * end for part in to_rgb(PALETTE[colour]))
    return Style(
        to_hex((r, g, b)),
        MARKERS[(colour + number) % len(MARKERS)],
        DASHES[(colour // 8 + number) % len(DASHES)],
    )


def subjects(run: RunRecord) -> dict[str, dict[str, str]]:
    """Table -> subject -> its system, for `styles`; that of a whole call is the method that was called."""
    found: dict[str, dict[str, str]] = {}
    systems = {subject.system for group in run.groups for subject in group.subjects.values()}
    for group in run.groups:
        for label, subject in group.subjects.items():
            method = (subject.params or {}).get("method")
            called = method in systems and label.startswith(f"{method}_")
            system = str(method) if called else subject.system
            found.setdefault(group.table, {})[label] = system or label
    return found


def varying(rows: Sequence[Row], keys: Iterable[str]) -> list[str]:
    """The keys whose value is not the same in all rows; of two that always agree, the first."""
    kept: dict[str, list[str]] = {}
    for key in keys:
        values = [str(row.get(key)) for row in rows]
        if len(set(values)) > 1 and values not in kept.values():
            kept[key] = values
    return list(kept)


def spoken(key: str) -> str:
    return key.replace("_", " ")


def case(row: Row, keys: Sequence[str]) -> str:
    """A row's case in words: names as they are, numbers with their key."""
    words = []
    for key in keys:
        value = row.get(key)
        if value is not None:
            words.append(value if isinstance(value, str) else f"{amount(value)} {spoken(key)}")
    return ", ".join(words)


def by(rows: Iterable[Row], name: Callable[[Row], str]) -> dict[str, list[Row]]:
    """Rows in groups, in order of first appearance."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(name(row), []).append(row)
    return found


def hidden(shown: int, cases: int) -> str:
    """What a caption says when not every case is drawn."""
    return "" if shown == cases else f" {shown} of {cases} cases are drawn; all are in the table."


def legend(canvas: Canvas, axes: Sequence[Axes]) -> None:
    """One legend above all panels."""
    found = {
        label: handle
        for a in axes
        for handle, label in zip(*a.get_legend_handles_labels(), strict=True)
    }
    columns = max(1, min(len(found), int(108 / (max(map(len, found)) + 6))))
    canvas.legend(
        found.values(), found.keys(), loc="outside upper left", ncols=columns, frameon=False
    )
