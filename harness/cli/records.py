"""Commands on what was measured: report, claims, plot, compare."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Annotated

import typer

from lodbench.harness.cli import complete, options
from lodbench.harness.cli.app import app
from lodbench.harness.cli.options import (
    DeviceOption,
    FilterOption,
    JsonOption,
    RunArgument,
    ThresholdOption,
)
from lodbench.harness.cli.output import say, say_json, say_rows


@app.command()
def report(
    folder: RunArgument,
    pictures: Annotated[
        bool, typer.Option("--pictures", help="Draw its pictures anew: methods are run again.")
    ] = False,
    device: DeviceOption = None,
    json_output: JsonOption = False,
) -> None:
    """Make a run's tables, figures and HTML report again from its records; with --pictures its pictures too.

    Example: lodbench report run_a
    """
    from lodbench.harness.report import derive

    made = derive.write_tables(folder)
    if pictures and (lacking := derive.draw_pictures(folder, device)):
        say(lacking)
    page = derive.write_report(folder)
    if json_output:
        say_json({"folder": folder, "report": page, "tables": made})
        return
    for document in made:
        say(str(folder / "tables" / f"{document['id']}.md"))
    say(str(page) if page else derive.NO_REPORT)


@app.command()
def claims(
    folders: Annotated[
        list[Path], typer.Argument(metavar="RUN...", help="A run's folder, or several.")
    ],
    json_output: JsonOption = False,
) -> None:
    """What the papers claim, what was published and measured, and the verdict: from the records of one run or several.

    A claim is confirmed where the whole 95 % interval of every case keeps to its rule, refuted where none does.

    Example: lodbench claims run_a
    """
    from lodbench.harness.record.record import read_run
    from lodbench.harness.report import claims as judge

    found = judge.verdicts([read_run(folder) for folder in folders])
    if json_output:
        say_json(found)
        return
    for one in found:
        say(f"{one['claim']} ({one['source']})")
        words = [one["verdict"], one["reason"]]
        for label in ("published", "measured", "rule"):
            if one[label]:
                say(f"  {label}: {one[label]}")
        say(f"  {': '.join(filter(None, words))}")
    counts = Counter(one["verdict"] for one in found)
    say(
        f"{len(found)} claims: {', '.join(f'{n} {verdict}' for verdict, n in counts.most_common())}"
    )


@app.command()
def plot(
    folder: RunArgument,
    x: Annotated[str, typer.Option("--x", help="The key of a column, or a fact of the case.")],
    y: Annotated[str, typer.Option("--y", help="The key of a column of numbers.")],
    series: Annotated[
        str, typer.Option("--by", help="The column that has a colour for each value.")
    ] = "system",
    table: Annotated[
        str | None,
        typer.Option("--table", autocompletion=complete.tables, help="Where the run has several."),
    ] = None,
    log: Annotated[
        str, typer.Option("--log", metavar="AXES", help="Logarithmic axes: x, y or xy.")
    ] = "",
    keep: FilterOption = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", help="The file, .png, .svg or .pdf; default TABLE-Y-X.png."),
    ] = None,
    json_output: JsonOption = False,
) -> None:
    """Draw any column of a run's table over any other, with intervals, in the report's colours.

    Example: lodbench plot run_a --x triangles_in --y wall_s --by system --log xy --out time.svg
    """
    from lodbench.harness.report.own_plot import write_plot

    pattern = options.pattern(keep) if keep else None
    path = out or Path(f"{table or 'plot'}-{y}-{x}.png")
    said = write_plot(folder, table, x, y, series, path, log, pattern)
    if json_output:
        say_json({"plot": path, "drawn": said})
    else:
        say(f"{path}: {said}")


@app.command()
def compare(
    a: Annotated[Path, typer.Argument(metavar="A", help="The run to compare with.")],
    b: Annotated[Path, typer.Argument(metavar="B", help="The run in question.")],
    again: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="[B2]...", help="More runs of B's code: slower is what is so in all."
        ),
    ] = None,
    threshold: ThresholdOption = 0.05,
    keep: FilterOption = None,
    json_output: JsonOption = False,
) -> None:
    """Match two runs row by row; exit code 1 where B is slower, fails, is worse, or has other rows.

    Slower: beyond threshold, and surer the more rows there are, so that of twenty comparisons of the same code one at
    the most says so. Worse: error, topology or the number of triangles.

    Example: lodbench compare run_a run_b
    """
    from lodbench.harness.record.record import read_run
    from lodbench.harness.report import compare as comparison

    pattern = options.pattern(keep) if keep else None
    first = read_run(a)
    found = comparison.compare(first, read_run(b), threshold, pattern)
    more = [comparison.compare(first, read_run(one), threshold / 2, pattern) for one in again or ()]
    comparison.confirm(found, more)
    if json_output:
        say_json(found)
    else:
        say_rows(comparison.COLUMNS, found["rows"])
        if not found["same_machine"]:
            say("the two runs are of different machines or devices: times say little")
        for row in found["rows"]:
            if row["verdict"] in comparison.WORSE:
                names = " ".join(str(row[key]) for key in ("table", "group", "system"))
                say(f"{row['verdict']}: {names}: {row['why']}")
        if found["too_few"]:
            say(
                f"{found['too_few']} rows have too few samples for a word on time: see --precision, --samples of run"
            )
        if found["busy"]:
            say(
                f"{found['busy']} rows were disturbed by other processes: nothing is said of their time"
            )
        say(f"{found['regressions']} regressions or unmatched in {len(found['rows'])} rows")
    raise typer.Exit(1 if found["regressions"] else 0)
