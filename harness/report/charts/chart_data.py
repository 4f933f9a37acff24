"""What charts are drawn from, and what they share: a table's rows, its groups, colours, the words for a case."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas

from lodbench.harness.measure.limits import Limits
from lodbench.harness.record.record import GroupRecord
from lodbench.harness.report.amounts import amount

Row = Mapping[str, Any]
Style = tuple[str, str]  # colour and marker

# Okabe & Ito's colours, told apart by readers who are colour-blind; without yellow and black, lost on a page
PALETTE = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c6d4f", "#7f7f7f",
)  # fmt: skip
MARKERS = "osD^vPX*"
DASHES = ("-", "--", ":", "-.")
EVERY: tuple[Style, ...] = tuple(
    (PALETTE[i % len(PALETTE)], MARKERS[(i + i // len(PALETTE)) % len(MARKERS)])
    for i in range(len(PALETTE) * len(MARKERS))
)
"""All styles, in the order in which they are given away: colours first."""
INK, FAINT, WARNING, PAGE = "#1f2328", "#d0d7de", "#b35900", "#ffffff"
ON_COLOUR = "#fefefe"  # text on a bar stays light where the page is dark

WIDTH = 7.4  # inches: the report's column


@dataclass(frozen=True)
class ChartData:
    """A table's document, the whole groups it was made from, a colour and marker per system, the device's limits."""

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
        return self.styles.get(system, (PALETTE[-1], "o"))


@dataclass(frozen=True)
class Chart:
    """A drawn canvas and the sentence under it."""

    canvas: Canvas
    caption: str


def styles(tables: Iterable[Iterable[str]]) -> dict[str, Style]:
    """A colour and marker per system, the same in every table, and different within one while colours last."""
    found: dict[str, Style] = {}
    for table in tables:
        systems = list(dict.fromkeys(table))
        taken = {found[name] for name in systems if name in found}
        free = (style for style in EVERY if style not in taken)
        for name in systems:
            if name not in found:
                found[name] = next(free, EVERY[-1])
    return found


def dash(style: Style) -> str:
    """The dash of a line: that of a colour's second system differs from that of its first."""
    return DASHES[EVERY.index(style) // len(PALETTE) % len(DASHES)] if style in EVERY else "-"


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
