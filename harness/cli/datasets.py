"""Commands on the surfaces that are measured: datasets list, make, fetch."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from lodbench.harness.cli import complete
from lodbench.harness.cli.app import app
from lodbench.harness.cli.files import FormatOption, MeshTarget, OutArgument, read_source
from lodbench.harness.cli.options import JsonOption
from lodbench.harness.cli.output import say, say_json, say_rows

datasets = typer.Typer(help="Surfaces to measure on: list, fetch, make.", no_args_is_help=True)
app.add_typer(datasets, name="datasets")


def dataset_rows() -> list[dict[str, Any]]:
    """What the catalogue holds, without making any of it."""
    from lodbench.datasets_gen import catalogue

    return [{"dataset": name, **facts} for name, facts in catalogue.describe().items()]


@datasets.command("list")
def list_datasets(json_output: JsonOption = False) -> None:
    """Surfaces by name, generated and read.

    Example: lodbench datasets list
    """
    rows = dataset_rows()
    if json_output:
        say_json(rows)
    else:
        say_rows([{"key": key, "label": key} for key in rows[0]], rows)


@datasets.command("make")
def make(
    name: Annotated[
        str,
        typer.Argument(
            help="A name from `lodbench datasets list`.", autocompletion=complete.dataset_names
        ),
    ],
    out: OutArgument,
    form: FormatOption = None,
) -> None:
    """Write a dataset of triangles to a file.

    Example: lodbench datasets make torus_20k torus.ply

    Piped: lodbench datasets make torus_20k - | lodbench simplify - small.ply -n 5000
    """
    from lodbench.datasets_gen import catalogue

    catalogue.find(name)
    target = MeshTarget(out, form)
    target.check()
    found = read_source(Path(name)).triangles()
    target.write_mesh(mesh := found.surface, found)
    target.say(f"{out}: {mesh.triangle_count:,} triangles, {mesh.vertex_count:,} points")


@datasets.command("fetch")
def fetch(
    names: Annotated[
        list[str] | None,
        typer.Argument(help="Default: all that can be had.", autocompletion=complete.scans),
    ] = None,
) -> None:
    """Download the classic scans into the data folder.

    Example: lodbench datasets fetch bunny_69k
    """
    from lodbench.datasets_gen import catalogue

    for path in catalogue.fetch(names or None, lambda line: say(line, err=True)):
        say(str(path))
