"""Measuring into a run's folder, and showing what came of it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lodbench.harness.cli.app import records_kept
from lodbench.harness.cli.options import Measuring, pattern
from lodbench.harness.cli.output import say, say_rows


def show(folder: Path, made: dict[str, Any]) -> None:
    """A table on the terminal: the main columns, and below it why rows are not ok."""
    from lodbench.harness.report import derive

    say_rows(derive.brief_columns(folder, made), made["rows"], made["title"])
    for line in derive.reasons(made):
        say(line)


def work_of(tables: Sequence[Any], quick: bool, keep: str | None) -> list[tuple[str, Any]]:
    """(table id, group) of all that is asked for, checked."""
    work = [(table.id, group) for table in tables for group in table.groups(quick)]
    if keep:
        wanted = pattern(keep)
        work = [(name, group) for name, group in work if wanted.search(f"{name}: {group.name}")]
        if not work:
            raise ValueError(f"filter: expected the name of some group, got {keep!r}")
    for _, group in work:
        group.validate()
    return work


def noted(how: Measuring, quick: bool, more: dict[str, Any]) -> dict[str, Any]:
    """The options that a run's folder keeps."""
    kept = ("samples", "precision", "time_budget")
    return {**{name: getattr(how, name) for name in kept}, "quick": quick, **more}


def measure(
    tables: Sequence[Any],
    how: Measuring,
    *,
    quick: bool,
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

    work = work_of(tables, quick, how.keep)
    device = Device.open(how.device)
    options = noted(how, quick, options)
    folder = open_folder(device, options, out=how.out, resume=how.resume, seed=how.seed)
    with records_kept(folder):
        session = Session(
            device, folder, samples=how.samples, time_budget_s=how.time_budget, seed=how.seed,
            precision=how.precision if how.precision is not None else 2 * NARROW if quick else NARROW,
        )  # fmt: skip
        try:
            if read_run(folder).limits is None:
                session.note("limits", **vars(limits.measure(device)))
            left_out = session.measure(work, how.quiet)
        finally:
            session.close()
        if not left_out:
            pack(folder)
    return folder, left_out


def tell_left_out(left_out: Sequence[str], folder: Path) -> None:
    if left_out:
        names = "; ".join(left_out)
        say(
            f"the time budget left out or cut short {len(left_out)} groups ({names}): "
            f"go on with --resume --out {folder}",
            err=True,
        )
