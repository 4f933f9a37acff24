"""Commands that measure systems x datasets x parameters: run, and sweep, here or over the machines of a cluster."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from lodbench.harness.cli.app import app, records_kept
from lodbench.harness.cli.measure import measure, noted, show, tell_left_out, work_of
from lodbench.harness.cli.options import (
    AgainstOption,
    CaseOption,
    DatasetsOption,
    Measuring,
    SettingsOption,
    SystemArgument,
    measuring,
    parameters,
)
from lodbench.harness.cli.output import hint, say, say_json, say_rows


def _here(
    spec: dict[str, Any], devices: Sequence[str | None], how: Measuring
) -> Iterator[tuple[Path, list[str]]]:
    """Measure on this machine's devices, one after the other; each folder, and what was left out."""
    from lodbench.harness.plan import sweep

    for number, name in enumerate(devices):
        out = how.out / f"device-{number}" if how.out is not None and len(devices) > 1 else how.out
        own = replace(how, device=name, out=out)
        yield measure([sweep.table(spec)], own, quick=False, options={"sweep": spec})


def _over_machines(
    spec: dict[str, Any], devices: Sequence[str | None], how: Measuring, address: str
) -> list[tuple[Path, list[str]]]:
    """Measure on the workers of a Dask cluster; each folder, and what was left out."""
    from lodbench.harness.measure.cluster import connected
    from lodbench.harness.measure.spread import Spread
    from lodbench.harness.measure.timing import NARROW
    from lodbench.harness.plan import sweep

    work = work_of([sweep.table(spec)], False, how.keep)
    precision = NARROW if how.precision is None else how.precision
    arguments = {"samples": how.samples, "precision": precision, "seed": how.seed}
    with connected(address) as cluster:
        spread = Spread(
            cluster, work, devices, arguments=arguments, options=noted(how, False, {"sweep": spec}),
            out=how.out, resume=how.resume, time_budget_s=how.time_budget, quiet=how.quiet,
        )  # fmt: skip
        with records_kept(how.out or Path("the last run's folder")):
            return spread.measure()


def _sweep(spec: dict[str, Any], how: Measuring, dask: str | None = None) -> None:
    from lodbench.harness.report import derive

    documents = []
    devices = [how.device] if how.device else spec.get("devices") or [None]
    if dask:
        measured = iter(_over_machines(spec, devices, how, dask))
    else:
        measured = _here(spec, devices, how)
    for folder, left_out in measured:
        with records_kept(folder):
            made = derive.write_tables(folder)
            documents += made
            report = derive.write_report(folder)
        if not how.json_output:
            for document in made:
                show(folder, document)
            say(f"records, tables{' and report' if report else ''}: {folder}")
        tell_left_out(left_out, folder)
    if how.json_output:
        say_json(documents)


def _tell_plan(spec: dict[str, Any], keep: str | None, names_only: bool, json_output: bool) -> None:
    """What a sweep would measure: a name a line, as --filter takes them, or a table."""
    from lodbench.harness.plan import sweep

    work = work_of([sweep.table(spec)], False, keep)
    if names_only and not json_output:
        for table, group in work:
            say(f"{table}: {group.name}")
        return
    rows = [
        {"group": f"{table}: {group.name}", "subjects": ", ".join(s.name for s in group.subjects)}
        for table, group in work
    ]
    if json_output:
        say_json(rows)
        return
    say_rows([{"key": key, "label": key} for key in rows[0]], rows)
    devices = spec.get("devices") or ["the default device"]
    subjects = sum(len(group.subjects) for _, group in work)
    say(f"{len(work)} groups, {subjects} rows, on {', '.join(devices)}; nothing was measured")


@app.command()
@measuring
def run(
    system: SystemArgument,
    dataset: DatasetsOption = None,
    against: AgainstOption = None,
    case: CaseOption = None,
    settings: SettingsOption = None,
    quality: Annotated[bool, typer.Option("--quality", help="Error and topology too.")] = False,
    *,
    how: Measuring,
) -> None:
    """Measure one system, alone or in turns with others, and show the row.

    Example: lodbench run quadric_clustering -d torus_20k -s cells=32 -a numpy_quadric_clustering
    """
    from lodbench.datasets_gen import catalogue
    from lodbench.harness.plan import registry, sweep

    registry.system(system)
    spec = sweep.validate(
        {
            "name": system,
            "systems": [system, *(against or [])],
            "datasets": dataset or [sweep.default_dataset(system)],
            "quality": quality,
            "params": parameters(settings),
            **({"case": case} if case else {}),
        }
    )
    for name in spec["datasets"]:
        if probably := catalogue.hint(name):
            hint(probably)
    _sweep(sweep.with_files(spec, Path()), how)


@app.command("sweep")
@measuring
def sweep_command(
    file: Annotated[Path, typer.Argument(help="TOML: systems, datasets, params (lists are axes).")],
    dask: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="Measure on the workers of this Dask scheduler."),
    ] = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Show what would be measured.")
    ] = False,
    names: Annotated[bool, typer.Option("--list", help="Its groups, a name a line.")] = False,
    *,
    how: Measuring,
) -> None:
    """Measure systems x datasets x parameters from a file; every sample is kept.

    Example: lodbench sweep grids.toml --samples 20 --out run_a

    Here grids.toml holds these lines; results/SWEEPS.md has all keys:

    systems = ["quadric_clustering", "numpy_quadric_clustering"]

    datasets = ["icosphere_5", "small.ply"]

    params = { cells = [32, 64] }
    """
    from lodbench.harness.plan import sweep

    spec = sweep.read(file)
    if dry_run or names:
        _tell_plan(spec, how.keep, names, how.json_output)
        return
    _sweep(spec, how, dask)
