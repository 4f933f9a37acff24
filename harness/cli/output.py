"""What the shell says: lines, JSON documents and tables that fit the terminal, in any character set."""

from __future__ import annotations

import codecs
import json
import sys
from collections.abc import Mapping, Sequence
from typing import Any

PIPE_COLUMNS = 1000  # a pipe or file has no width of its own: lines are as long as they need to be
LONGEST_WORD = 40  # columns; longer words, such as paths in a reason, are folded
NAMES = ("dataset", "system")  # stand in every part of a table too wide for the terminal
_GAP = 3  # columns of padding and rule beside each cell
_SPOKEN = {"µ": "u", "–": "-", "−": "-", "×": "x", "°": " degrees", "≤": "<=", "≥": ">="}
_COLOURS = {"failed": "red", "noisy": "yellow", "skipped": "dim"}


def _spell(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(_SPOKEN.get(c, "?") for c in error.object[error.start : error.end]), error.end


codecs.register_error("lodbench", _spell)


def say_in_any_encoding() -> None:
    """Have standard output and error spell what their character set lacks: `us` for `µs`, `?` for the rest."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="lodbench")  # pyright: ignore[reportAttributeAccessIssue]


def say(text: str = "", err: bool = False) -> None:
    """A line on standard output, or with `err` on standard error."""
    stream = sys.stderr if err else sys.stdout
    stream.write(f"{text}\n")
    stream.flush()


def hint(text: str) -> None:
    """A line on standard error that may help and is no error."""
    say(f"hint: {text}", err=True)


def say_json(value: Any) -> None:
    """A JSON document on standard output."""
    from lodbench.harness.record.record import plain

    say(json.dumps(plain(value), indent=1))


def _least(label: str, cells: Sequence[str], is_text: bool) -> int:
    """The width below which a word, or a number with its unit, would break."""
    words = [
        *label.split(),
        *(word for cell in cells for word in (cell.split() if is_text else [cell])),
    ]
    return min(max(map(len, words), default=1), LONGEST_WORD)


def _parts(least: Sequence[int], names: Sequence[int], room: int) -> list[list[int]]:
    """Columns side by side, as many as have room; where that is not all, each part begins with `names`."""

    def needed(columns: Sequence[int]) -> int:
        return sum(least[column] + _GAP for column in columns)

    if needed(range(len(least))) <= room:
        return [list(range(len(least)))]
    first = list(names)
    while first:
        others = [least[column] for column in range(len(least)) if column not in first]
        if needed(first) + _GAP + max(others, default=0) <= room:
            break
        first.pop(0)
    rest = [column for column in range(len(least)) if column not in first]
    parts = [[*first]]
    for column in rest:
        if needed([*parts[-1], column]) > room and len(parts[-1]) > len(first):
            parts.append([*first])
        parts[-1].append(column)
    return parts


def _widths(least: Sequence[int], most: Sequence[int], room: int) -> list[int]:
    """Widths between `least` and `most` that share `room`, narrow columns first."""
    widths = list(least)
    spare = room - sum(widths) - _GAP * len(widths)
    order = sorted(range(len(widths)), key=lambda c: most[c] - least[c])
    for number, column in enumerate(order):
        more = max(0, min(most[column] - least[column], spare // (len(order) - number)))
        widths[column] += more
        spare -= more
    return widths


def say_rows(
    columns: Sequence[Mapping[str, str]], rows: Sequence[Mapping[str, Any]], title: str = ""
) -> None:
    """A table on standard output; columns without a value are left out.

    No name or number is broken: what a terminal has no room for beside the others goes on below, with the rows'
    names again.
    """
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    from lodbench.harness.report.amounts import amount

    console = Console(width=None if sys.stdout.isatty() else PIPE_COLUMNS)
    room = console.width - 1
    shown = [c for c in columns if any(row.get(c["key"]) not in (None, "") for row in rows)]
    if not shown:
        if title:
            say(title)
        return
    cells = [[amount(row.get(c["key"]), c.get("unit", "")) for row in rows] for c in shown]
    is_text = [all(isinstance(row.get(c["key"]), str | None) for row in rows) for c in shown]
    least = [
        _least(c["label"], column, text)
        for c, column, text in zip(shown, cells, is_text, strict=True)
    ]
    most = [
        max(low, len(c["label"]), *map(len, column))
        for c, column, low in zip(shown, cells, least, strict=True)
    ]
    names = [
        i
        for i, (c, column) in enumerate(zip(shown, cells, strict=True))
        if c["key"] in NAMES and len(set(column)) > 1
    ] or [0]
    for number, part in enumerate(_parts(least, names, room)):
        grid = Table(
            title=title if title and not number else None, title_justify="left", box=box.SIMPLE_HEAD
        )
        widths = _widths([least[c] for c in part], [most[c] for c in part], room)
        for column, width in zip(part, widths, strict=True):
            grid.add_column(
                shown[column]["label"], justify="left" if is_text[column] else "right",
                overflow="fold", width=width,
            )  # fmt: skip
        for index, row in enumerate(rows):
            texts = [Text(cells[column][index]) for column in part]
            grid.add_row(*texts, style=_COLOURS.get(str(row.get("status"))))
        console.print(grid)
