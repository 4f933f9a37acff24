"""The command that measures the papers' tables: reproduce."""

from __future__ import annotations

from typing import Annotated

import typer

from lodbench.harness.cli.app import app, records_kept
from lodbench.harness.cli.measure import measure, show, tell_left_out
from lodbench.harness.cli.options import Measuring, TablesArgument, measuring
from lodbench.harness.cli.output import say, say_json


@app.command()
@measuring
def reproduce(
    names: TablesArgument = None,
    quick: Annotated[bool, typer.Option("--quick", help="Smaller inputs: minutes.")] = False,
    *,
    how: Measuring,
) -> None:
    """Measure the papers' tables, and make tables, figures and one HTML report of them.

    Example: lodbench reproduce --quick
    """
    from lodbench.harness.plan.table import table, tables
    from lodbench.harness.report import derive

    chosen = [table(name) for name in names] if names else list(tables().values())
    folder, left_out = measure(chosen, how, quick=quick, options={})
    with records_kept(folder):
        made = derive.write_tables(folder)
        if lacking := derive.draw_pictures(folder, how.device):
            say(lacking)
        page = derive.write_report(folder)
    if how.json_output:
        say_json({"folder": folder, "report": page, "tables": made})
    else:
        for document in made:
            show(folder, document)
        counts = ", ".join(f"{n} {status}" for status, n in derive.statuses(made).items())
        say(f"{len(made)} tables ({counts}): {folder / 'tables'}")
        say(f"report: {page}" if page else derive.NO_REPORT)
    tell_left_out(left_out, folder)
