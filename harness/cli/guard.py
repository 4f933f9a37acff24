"""The command that guards speed: guard."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Annotated, Any

import typer

from lodbench.harness.cli.app import Stopped, app
from lodbench.harness.cli.measure import measure
from lodbench.harness.cli.options import (
    DeviceOption,
    JsonOption,
    Measuring,
    OutOption,
    QuietOption,
    ThresholdOption,
)
from lodbench.harness.cli.output import say, say_json, say_rows

COLUMNS = [
    {"key": key, "label": label, "unit": unit}
    for key, label, unit in (
        ("table", "table", ""),
        ("group", "group", ""),
        ("system", "system", ""),
        ("against", "relative to", ""),
        ("ratio", "now / then", "1"),
        ("ratio_low", "low", "1"),
        ("ratio_high", "high", "1"),
        ("verdict", "verdict", ""),
        ("why", "why", ""),
    )
]


@app.command()
def guard(
    reference: Annotated[
        Path, typer.Option("--reference", help="A recorded run, or a folder of such.")
    ] = Path("results/reference"),
    seconds: Annotated[
        float, typer.Option("--seconds", min=0.0, help="About how long to measure.")
    ] = 60.0,
    threshold: ThresholdOption = 0.20,
    device: DeviceOption = None,
    out: OutOption = None,
    json_output: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Measure the quickest cases of recorded runs again; exit code 1 where one got slower, or its result worse.

    Times are taken relative to NumPy forms and to copying memory, so that the recorded run may be another machine's.

    Example: lodbench guard --reference run_a --seconds 5
    """
    from lodbench.harness.record.record import read_run
    from lodbench.harness.report import guard as guards
    from lodbench.harness.report.compare import WORSE

    rows: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory(prefix="lodbench-guard-") as folder:
        work = list(guards.chosen(guards.recorded(reference), seconds))
        if not work:
            raise ValueError(
                f"reference: expected cases that can be run here, got none in {reference}"
            )
        for number, (before, tables) in enumerate(work):
            own, _ = measure(
                tables,
                Measuring(device, (out or Path(folder)) / f"run-{number}", quiet=quiet),
                quick=bool(before.environment["options"].get("quick")),
                options={"sweep": before.environment["options"].get("sweep")},
            )
            rows += guards.judged(before, read_run(own), threshold)
    if not rows:
        raise ValueError(
            f"reference: expected rows of a device in both runs, got none in {reference}"
        )
    worse = [row for row in rows if row["verdict"] in WORSE]
    if json_output:
        say_json({"rows": rows, "regressions": len(worse), "threshold": threshold})
    else:
        say_rows(COLUMNS, rows)
        for row in worse:
            times = f", {row['ratio']:.2f} times as long" if row["ratio"] else ""
            names = " ".join(str(row[key]) for key in ("table", "group", "system"))
            say(f"worse: {names}: {row['why']}{times} relative to {row['against']}")
        counts = {kind: sum(row["verdict"] == kind for row in rows) for kind in ("too few", "busy")}
        words = {
            "too few": "with too few samples for a word on time",
            "busy": "in a group that other processes disturbed, of whose time nothing is said",
        }
        rest = "".join(f", {n} {words[kind]}" for kind, n in counts.items() if n)
        say(f"{len(worse)} of {len(rows)} rows got worse{rest}")
    if not worse and all(row["verdict"] == "busy" for row in rows):
        raise Stopped(2, "the machine was busy throughout: nothing is known of time; run it again")
    raise typer.Exit(1 if worse else 0)
