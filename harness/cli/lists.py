"""Commands that say what there is, and what is wrong: doctor, list."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from lodbench.harness.cli import complete
from lodbench.harness.cli.app import app
from lodbench.harness.cli.options import FilterOption, JsonOption, pattern
from lodbench.harness.cli.output import hint, say_json, say_rows


@app.command()
def doctor(json_output: JsonOption = False) -> None:
    """Say what is wrong with OpenCL on this machine, and the exact line that mends it.

    Example: lodbench doctor
    """
    from lodbench.harness.doctor import examine

    raise typer.Exit(examine.main(json_output))


lists = typer.Typer(help="What there is: systems, datasets, tables, devices.", no_args_is_help=True)
app.add_typer(lists, name="list")


def _listing(rows: list[dict[str, Any]], json_output: bool, keep: str | None) -> None:
    if keep:
        found = pattern(keep)
        rows = [row for row in rows if found.search(" ".join(map(str, row.values())))]
    if json_output:
        say_json(rows)
    elif rows:
        say_rows([{"key": key, "label": key} for key in rows[0]], rows)
    else:
        hint(f"nothing there{f' that {keep} matches' if keep else ''}")


@lists.command("systems")
def list_systems(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="[NAME]",
            autocompletion=complete.systems,
            help="One of them, with its parameters.",
        ),
    ] = None,
    json_output: JsonOption = False,
    keep: FilterOption = None,
) -> None:
    """Systems and baselines, with their cases; or one system's parameters.

    Example: lodbench list systems --filter cluster
    """
    from lodbench.harness.plan.registry import registry, system
    from lodbench.kernels.parameters import described

    if name is not None:
        _listing(described(type(next(iter(system(name).cases.values())))), json_output, keep)
        return
    found = registry()
    rows = [
        {
            "system": s.name,
            "family": s.family,
            "runs on": s.runs_on,
            "takes": ", ".join(kind.__name__ for kind in s.takes),
            "verbs": ", ".join(s.verbs),
            "cases": ", ".join(s.cases),
            "source": s.source,
        }
        for s in found.systems.values()
    ]
    rows += [
        {"system": name, "family": "", "runs on": "", "takes": "", "verbs": "", "cases": "",
         "source": f"cannot be used here: {reason}"}
        for name, reason in found.missing.items()
    ]  # fmt: skip
    _listing(rows, json_output, keep)


@lists.command("tables")
def list_tables(json_output: JsonOption = False, keep: FilterOption = None) -> None:
    """Tables and figures that `reproduce` makes.

    Example: lodbench list tables
    """
    from lodbench.harness.plan.table import tables

    rows = [{"table": t.id, "title": t.title, "source": t.source} for t in tables().values()]
    _listing(rows, json_output, keep)


@lists.command("devices")
def list_devices(json_output: JsonOption = False, keep: FilterOption = None) -> None:
    """OpenCL devices, by the index and the names that --device takes.

    Example: lodbench list devices
    """
    from lodbench.kernels.opencl import driver

    found = driver.list_devices()
    if not found:
        driver.choose_device("")  # raises what is in the way
    rows = [{"index": i, "platform": p, "device": d} for i, p, d, _ in found]
    _listing(rows, json_output, keep)


@lists.command("datasets")
def list_datasets(json_output: JsonOption = False, keep: FilterOption = None) -> None:
    """Surfaces by name, generated and read.

    Example: lodbench list datasets --filter torus
    """
    from lodbench.harness.cli.datasets import dataset_rows

    _listing(dataset_rows(), json_output, keep)
