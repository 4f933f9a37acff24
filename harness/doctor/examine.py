"""What is wrong with OpenCL on this machine, and the exact line that mends it. Never a traceback."""

from __future__ import annotations

import dataclasses
import importlib.util
import json
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from statistics import median
from typing import Any

from lodbench.harness.doctor import intel, opencl
from lodbench.harness.doctor.opencl import Finding, pip, writable

BUSY, UNSTEADY = 0.15, 0.10  # shares: other processes' CPU time; spread of a fixed piece of work
CORE = (
    "pyopencl", "numpy", "scipy", "trimesh", "fast_simplification", "matplotlib", "typer", "rich", "psutil",
    "platformdirs",
)  # fmt: skip
EXTRAS = {
    "report": ({"igl": "libigl", "jinja2": "jinja2"}, "error columns and the HTML report"),
    "datasets": ({"pooch": "pooch"}, "downloads of the classic scans"),
    "peers": (
        {"vtk": "vtk", "meshoptimizer": "meshoptimizer", "manifold3d": "manifold3d", "pyfqmr": "pyfqmr",
         "splipy": "splipy", "geomdl": "geomdl"},
        "more packages to compare with",
    ),
    "gl": ({"moderngl": "moderngl"}, "comparison with a real OpenGL driver"),
}  # fmt: skip


def _missing(modules: Mapping[str, str]) -> list[str]:
    return [package for name, package in modules.items() if importlib.util.find_spec(name) is None]


def _packages() -> Iterator[Finding]:
    missing = _missing({name: name for name in CORE})
    names = ["pyopencl[pocl]" if name == "pyopencl" else name.replace("_", "-") for name in missing]
    detail = f"Python {sys.version.split()[0]}"
    if missing:
        yield Finding("packages", "fail", f"{detail}; missing: {', '.join(missing)}", pip(*names))
    else:
        yield Finding("packages", "ok", f"{detail}, all there")


def _folders(results: Path) -> Iterator[Finding]:
    if reason := writable(results):
        detail = f"{results.absolute()}: cannot be written: {reason}"
        yield Finding(
            "results folder", "fail", detail, 'lodbench reproduce --out "$(mktemp -d)/run"'
        )
    else:
        yield Finding("results folder", "ok", str(results.absolute()))
    data = os.environ.get("LODBENCH_DATA")
    if data and not Path(data).is_dir():
        yield Finding(
            "data folder",
            "warn",
            f"LODBENCH_DATA names {data}, which is no folder",
            "unset LODBENCH_DATA",
        )
    else:
        yield Finding(
            "data folder",
            "ok",
            data or "LODBENCH_DATA is not set: stand-ins take the scans' place",
        )


def _extras() -> Iterator[Finding]:
    for name, (modules, purpose) in EXTRAS.items():
        missing = _missing(modules)
        if missing:
            detail = f"missing {', '.join(missing)}: {purpose}"
            yield Finding(f"extra [{name}]", "warn", detail, pip(*missing))
        else:
            yield Finding(f"extra [{name}]", "ok", purpose)


def _noise() -> Iterator[Finding]:
    import psutil

    busy = psutil.cpu_percent(interval=0.5) / 100
    seconds = []
    for _ in range(15):
        start = time.perf_counter()
        sum(range(200_000))
        seconds.append(time.perf_counter() - start)
    middle = median(seconds)
    spread = median(abs(s - middle) for s in seconds) / middle
    detail = f"{psutil.cpu_count()} CPUs, {busy:.0%} busy with other work; equal work varies by {spread:.1%}"
    if busy > BUSY or spread > UNSTEADY:
        yield Finding("quiet machine", "warn", f"{detail}: rows will be marked noisy")
    else:
        yield Finding("quiet machine", "ok", detail)


def diagnose(results: Path = Path("results")) -> list[Finding]:
    """Everything looked at, in the order in which one thing needs the other."""
    findings: list[Finding] = []
    checks: dict[str, Callable[[], Iterator[Finding]]] = {
        "packages": _packages, "Intel's runtime": intel.driver_file, "driver files": opencl.icds,
        "caches": opencl.caches, "OpenCL": opencl.opencl,
        "folders": lambda: _folders(results), "extras": _extras, "quiet machine": _noise,
    }  # fmt: skip
    for name, check in checks.items():
        try:
            findings += check()
        except Exception as error:  # the doctor has to go on where anything at all may be broken
            findings.append(Finding(name, "fail", f"could not be looked at: {error!r}"))
    return findings


def print_report(findings: list[Finding], console: Any) -> int:
    """Show the findings on a rich console; the exit code: 1 if anything failed, else 0."""
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    for title in ("", "what", "found"):
        table.add_column(title, overflow="fold")
    marks = {"ok": "[green]ok[/]", "warn": "[yellow]warn[/]", "fail": "[red]FAIL[/]"}
    for finding in findings:
        what, detail = (text.replace("[", "\\[") for text in (finding.what, finding.detail))
        table.add_row(marks[finding.status], what, detail)
    console.print(table)
    for finding in findings:
        if finding.mend:
            title = "to mend" if finding.status == "fail" else "to improve"
            console.print(f"\n{title} {finding.what}:", markup=False, highlight=False)
            console.print(f"    {finding.mend}", markup=False, highlight=False, soft_wrap=True)
    failed = [finding.what for finding in findings if finding.status == "fail"]
    console.print(
        f"\nfailed: {', '.join(failed)}" if failed else "\nlodbench can run here", markup=False
    )
    return 1 if failed else 0


def main(json_output: bool = False) -> int:
    """Look at everything and tell, for people or as JSON; the exit code."""
    findings = diagnose()
    if json_output:
        found = [dataclasses.asdict(finding) for finding in findings]
        sys.stdout.write(json.dumps(found, indent=1) + "\n")
        return int(any(finding.status == "fail" for finding in findings))
    from rich.console import Console

    return print_report(findings, Console(width=None if sys.stdout.isatty() else 160))
