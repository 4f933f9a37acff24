"""Where a run was measured, and how to do it again, in words."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping
from typing import Any

from lodbench.harness.record.record import RunRecord
from lodbench.harness.report.amounts import amount


def _entries(values: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Keys and values in words; nested ones are joined."""
    for key, value in values.items():
        unit = "B" if key.endswith("_bytes") else ""
        label = key.removesuffix("_bytes").replace("_", " ")
        if isinstance(value, Mapping):
            inside = ", ".join(f"{name} {text}" for name, text in _entries(value))
            yield label, inside or "none"
        elif isinstance(value, list):
            yield label, ", ".join(amount(item) for item in value) or "none"
        else:
            yield label, amount(value, unit)


def _limits(limits: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for key, value in limits.items():
        label = key.replace("_", " ")
        if isinstance(value, Mapping) and "best" in value:
            best, median = (amount(value[which], value["unit"]) for which in ("best", "median"))
            yield label, f"{best} best, {median} median ({value['subject']})"
        elif not isinstance(value, Mapping | list):
            yield label, amount(value, "B" if key.endswith("_bytes") else "")


def environment(run: RunRecord) -> list[tuple[str, list[tuple[str, str]]]]:
    """Blocks of keys and values: machine, device, its limits, packages, variables, options."""
    e = run.environment
    device = {k: v for k, v in e["device"].items() if k != "extensions"}
    versions = {name: version or "absent" for name, version in e.get("packages", {}).items()}
    made = {
        "Machine": {**e.get("machine", {}), "started": e["started"]},
        "Device": {**device, "pocl": e.get("pocl"), "llvm": e.get("llvm")},
        "Packages": versions,
        "Variables": e.get("variables", {}),
        "Options": {**e.get("options", {}), "seed": e.get("seed")},
    }
    blocks = [(name, list(_entries(values))) for name, values in made.items() if values]
    if run.limits:
        blocks.insert(2, ("Limits of the device, measured in this run", list(_limits(run.limits))))
    return blocks


def again(run: RunRecord) -> str:
    """The commands that measure this again, and make this file again."""
    e, options = run.environment, run.environment.get("options", {})
    made = []
    if e["commit"] != "unknown":
        made += [f"git checkout {e['commit']}", "make setup"]
    if isinstance(options.get("sweep"), Mapping):
        made.append(f"lodbench sweep {shlex.quote(str(options['sweep'].get('name', 'FILE')))}.toml")
    else:
        words = ["lodbench reproduce", *run.tables]
        words += ["--quick"] if options.get("quick") else []
        for key in ("samples", "time_budget"):
            if options.get(key) is not None:
                words += [f"--{key.replace('_', '-')} {options[key]}"]
        made.append(" ".join(words))
    made.append(
        f"lodbench report {shlex.quote(run.folder.name)}   # tables, figures and this file, from the records"
    )
    return "\n".join(made)
