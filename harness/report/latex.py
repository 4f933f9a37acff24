"""A table as LaTeX with booktabs, for a paper: the columns that a terminal shows, one unit each, ranges in brackets."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from lodbench.harness.report.table_view import every_column, lines

_SPECIAL = {
    "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}",
    **{sign: "\\" + sign for sign in "&%$#_{}"},
    "<": r"\textless{}", ">": r"\textgreater{}", "|": r"\textbar{}",
    "×": r"$\times$", "µ": r"\textmu{}", "−": "$-$", "–": "--", "±": r"$\pm$", "≤": r"$\le$", "≥": r"$\ge$",
    **{sign: f"$^{{{digits}}}$" for sign, digits in (("⁻³", "-3"), ("⁻⁶", "-6"))},
}  # fmt: skip
_SIGN = re.compile("|".join(re.escape(sign) for sign in sorted(_SPECIAL, key=len, reverse=True)))


def escaped(text: str) -> str:
    """`text` as LaTeX sets it, every sign with a meaning of its own made plain."""
    return _SIGN.sub(lambda found: _SPECIAL[found[0]], text)


def latex(made: Mapping[str, Any], brief: Sequence[str] = ()) -> str:
    """A `table` environment with the document's rows; needs the booktabs package alone.

    Args:
        made: a table's document.
        brief: the keys of its columns; none: all that have values. What has its ends in columns of their own has them
            in brackets. A row that is not all right says so by a note below the table.
    """
    shown = (
        [column for column in every_column(made) if column.key != "status"] if made["rows"] else []
    )
    if brief:
        shown = [column for key in brief for column in shown if column.key == key]
    head = [
        escaped(f"{column.label} [{column.unit}]" if column.unit else column.label)
        for column in shown
    ]
    body, marked = [], []
    for line in lines(made, (), shown):
        cells = [
            escaped(cell.text)
            + (f" {{\\footnotesize {escaped(cell.range)}}}" if cell.range else "")
            for cell in line.cells
        ]
        if line.status not in ("ok", "published"):
            marked += [line.status] if line.status not in marked else []
            cells[0] += f"$^{{{_letter(marked.index(line.status))}}}$" if cells else ""
        body.append(" & ".join(cells) + r" \\")
    notes = [f"$^{{{_letter(number)}}}$ {status}" for number, status in enumerate(marked)]
    said = (
        f"{escaped(made['title'])}. {escaped(made['source'])}. Device: {escaped(made['device'])}."
    )
    return "\n".join(
        (
            r"% \usepackage{booktabs}",
            r"\begin{table}",
            r"\centering",
            rf"\caption{{{said}}}",
            rf"\label{{tab:{made['id']}}}",
            rf"\begin{{tabular}}{{{''.join('l' if 't' in c.css.split() else 'r' for c in shown) or 'l'}}}",
            r"\toprule",
            " & ".join(head) + r" \\",
            r"\midrule",
            *body,
            r"\bottomrule",
            r"\end{tabular}",
            *([r"\par\footnotesize " + ", ".join(notes)] if notes else []),
            r"\end{table}",
            "",
        )
    )


def _letter(number: int) -> str:
    return "abc"[number]
