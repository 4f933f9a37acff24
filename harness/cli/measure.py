"""Commands that measure: run, sweep, reproduce."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from lodbench.harness.cli.app import app, records_kept
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
    TablesArgument,
    parameters,
    pattern,
)
from lodbench.harness.cli.output import hint, say, say_json, say_rows


def show(folder: Path, made: dict[str, Any]) -> None:
    """A table on the terminal: the main columns, and below it why rows are not ok."""
    from lodbench.harness.report import derive

    say_rows(derive.brief_columns(folder, made), made["rows"], made["title"])
    for line in derive.reasons(made):
        say(line)


def measure(
    tables: Sequence[Any],
    *,
    device_name: str | None,
    out: Path | None,
    resume: bool,
    samples: int | None,
    precision: float | None,
    time_budget: float | None,
    keep: str | None,
    seed: int,
    quick: bool,
    quiet: bool,
    options: dict[str, Any],
) -> tuple[Path, list[str]]:
    """Measure these tables' groups into one run folder; returns it and what the time budget did not suffice for."""
    from lodbench.harness.measure import limits
    from lodbench.harness.measure.run import Session
    from lodbench.harness.measure.timing import NARROW
    from lodbench.harness.record.folder import open_folder
    from lodbench.harness.record.record import read_run
    from lodbench.harness.record.samples import pack
    from lodbench.kernels.opencl import Device

    work = [(table.id, group) for table in tables for group in table.groups(quick)]
    if keep:
        wanted = pattern(keep)
        work = [(name, group) for name, group in work if wanted.search(f"{name}: {group.name}")]
        if not work:
            raise ValueError(f"filter: expected the name of some group, got {keep!r}")
    for _, group in work:
        group.validate()
    device = Device.open(device_name)
    options = {
        "samples": samples, "precision": precision, "time_budget": time_budget, "quick": quick, **options,
    }  # fmt: skip
    folder = open_folder(device, options, out=out, resume=resume, seed=seed)
    with records_kept(folder):
        session = Session(
            device, folder, samples=samples, time_budget_s=time_budget, seed=seed,
            precision=NARROW if precision is None else precision,
        )  # fmt: skip
        try:
            if read_run(folder).limits is None:
                session.note("limits", **vars(limits.measure(device)))
            left_out = session.measure(work, quiet)
        finally:
            session.close()
        if not left_out:
            pack(folder)
    return folder, left_out


def _tell_left_out(left_out: Sequence[str], folder: Path) -> None:
    if left_out:
        names = "; ".join(left_out)
        say(
            f"the time budget left out or cut short {len(left_out)} groups ({names}): "
            f"go on with --resume --out {folder}",
            err=True,
        )


def _sweep(spec: dict[str, Any], folder_of: Path | None, json_output: bool, **given: Any) -> None:
    from lodbench.harness.plan import sweep
    from lodbench.harness.report import derive

    documents = []
    asked = given.pop("device_name")
    devices = [asked] if asked else spec.get("devices") or [None]
    for number, name in enumerate(devices):
        out = folder_of
        if out is not None and len(devices) > 1:
            out = out / f"device-{number}"
        folder, left_out = measure(
            [sweep.table(spec)], device_name=name, out=out, quick=False,
            options={"sweep": spec}, **given,
        )  # fmt: skip
        with records_kept(folder):
            made = derive.write_tables(folder)
            documents += made
            report = derive.write_report(folder)
        if not json_output:
            for document in made:
                show(folder, document)
            say(f"records, tables{' and report' if report else ''}: {folder}")
        _tell_left_out(left_out, folder)
    if json_output:
        say_json(documents)


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

    _sweep(
        sweep.read(file), out, json_output, device_name=device, resume=resume, samples=samples,
        precision=precision, time_budget=time_budget, keep=keep, seed=seed, quiet=quiet,
    )  # fmt: skip


@app.command()
def reproduce(
    names: TablesArgument = None,
    quick: Annotated[bool, typer.Option("--quick", help="Smaller inputs: minutes.")] = False,
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
    """Measure the papers' tables, and make tables, figures and one HTML report of them.

    Example: lodbench reproduce --quick
    """
    from lodbench.harness.plan.table import table, tables
    from lodbench.harness.report import derive

    chosen = [table(name) for name in names] if names else list(tables().values())
    folder, left_out = measure(
        chosen, device_name=device, out=out, resume=resume, samples=samples,
        precision=precision, time_budget=time_budget, keep=keep, seed=seed, quick=quick, quiet=quiet, options={},
    )  # fmt: skip
    with records_kept(folder):
        made = derive.write_tables(folder)
        if lacking := derive.draw_pictures(folder, device):
            say(lacking)
        page = derive.write_report(folder)
    if json_output:
        say_json({"folder": folder, "report": page, "tables": made})
    else:
        for document in made:
            show(folder, document)
        counts = ", ".join(f"{n} {status}" for status, n in derive.statuses(made).items())
        say(f"{len(made)} tables ({counts}): {folder / 'tables'}")
        say(f"report: {page}" if page else derive.NO_REPORT)
    _tell_left_out(left_out, folder)
