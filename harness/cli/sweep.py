"""Commands that measure systems x datasets x parameters: run, and sweep, here or over the machines of a cluster."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from lodbench.harness.cli.app import app, records_kept
from lodbench.harness.cli.measure import measure, show, tell_left_out, work_of
from lodbench.harness.cli.options import (
    AgainstOption,
    BudgetOption,
    CaseOption,
    DatasetsOption,
    DeviceOption,
    FilterOption,
    JsonOption,
    OutOption,
    PrecisionOption,
    QuietOption,
    ResumeOption,
    SamplesOption,
    SeedOption,
    SettingsOption,
    SystemArgument,
    parameters,
)
from lodbench.harness.cli.output import hint, say, say_json, say_rows


def _here(
    spec: dict[str, Any], devices: Sequence[str | None], out: Path | None, **given: Any
) -> Iterator[tuple[Path, list[str]]]:
    """Measure on this machine's devices, one after the other; each folder, and what was left out."""
    from lodbench.harness.plan import sweep

    for number, name in enumerate(devices):
        yield measure(
            [sweep.table(spec)], device_name=name, quick=False, options={"sweep": spec},
            out=out / f"device-{number}" if out is not None and len(devices) > 1 else out, **given,
        )  # fmt: skip


def _over_machines(
    spec: dict[str, Any],
    devices: Sequence[str | None],
    out: Path | None,
    address: str,
    *,
    samples: int | None,
    precision: float | None,
    time_budget: float | None,
    seed: int,
    resume: bool,
    keep: str | None,
    quiet: bool,
) -> list[tuple[Path, list[str]]]:
    """Measure on the workers of a Dask cluster; each folder, and what was left out."""
    from lodbench.harness.measure.cluster import connected
    from lodbench.harness.measure.spread import Spread
    from lodbench.harness.measure.timing import NARROW
    from lodbench.harness.plan import sweep

    work = work_of([sweep.table(spec)], False, keep)
    arguments = {
        "samples": samples, "precision": NARROW if precision is None else precision, "seed": seed,
    }  # fmt: skip
    options = {
        "samples": samples, "precision": precision, "time_budget": time_budget, "quick": False,
        "sweep": spec,
    }  # fmt: skip
    with connected(address) as cluster:
        spread = Spread(
            cluster, work, devices, arguments=arguments, options=options, out=out, resume=resume,
            time_budget_s=time_budget, quiet=quiet,
        )  # fmt: skip
        with records_kept(out or Path("the last run's folder")):
            return spread.measure()


def _sweep(
    spec: dict[str, Any],
    out: Path | None,
    json_output: bool,
    *,
    device_name: str | None,
    dask: str | None = None,
    **given: Any,
) -> None:
    from lodbench.harness.report import derive

    documents = []
    devices = [device_name] if device_name else spec.get("devices") or [None]
    if dask:
        measured = iter(_over_machines(spec, devices, out, dask, **given))
    else:
        measured = _here(spec, devices, out, **given)
    for folder, left_out in measured:
        with records_kept(folder):
            made = derive.write_tables(folder)
            documents += made
            report = derive.write_report(folder)
        if not json_output:
            for document in made:
                show(folder, document)
            say(f"records, tables{' and report' if report else ''}: {folder}")
        tell_left_out(left_out, folder)
    if json_output:
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
def run(
    system: SystemArgument,
    dataset: DatasetsOption = None,
    against: AgainstOption = None,
    case: CaseOption = None,
    settings: SettingsOption = None,
    quality: Annotated[bool, typer.Option("--quality", help="Error and topology too.")] = False,
    device: DeviceOption = None,
    out: OutOption = None,
    samples: SamplesOption = None,
    precision: PrecisionOption = None,
    time_budget: BudgetOption = None,
    keep: FilterOption = None,
    resume: ResumeOption = False,
    seed: SeedOption = 0,
    json_output: JsonOption = False,
    quiet: QuietOption = False,
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
    _sweep(
        sweep.with_files(spec, Path()), out, json_output, device_name=device, resume=resume, samples=samples,
        precision=precision, time_budget=time_budget, keep=keep, seed=seed, quiet=quiet,
    )  # fmt: skip


@app.command("sweep")
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
    device: DeviceOption = None,
    out: OutOption = None,
    samples: SamplesOption = None,
    precision: PrecisionOption = None,
    time_budget: BudgetOption = None,
    keep: FilterOption = None,
    resume: ResumeOption = False,
    seed: SeedOption = 0,
    json_output: JsonOption = False,
    quiet: QuietOption = False,
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
        _tell_plan(spec, keep, names, json_output)
        return
    _sweep(
        spec, out, json_output, device_name=device, dask=dask, resume=resume, samples=samples,
        precision=precision, time_budget=time_budget, keep=keep, seed=seed, quiet=quiet,
    )  # fmt: skip
