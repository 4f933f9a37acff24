"""The record of a run: `run.json` (where and how) and `samples.jsonl` (one row per sample, as it happens).

A row is a JSON object with a `kind`; all but `limits` name their `group` (a hash of its configuration) and `attempt`:

```
begin      table, name, dataset, config, facts        a group of interleaved subjects starts
setup      subject, params, phases, from_cache        build, first_launch, upload ... seconds; memory growth
sample     subject, turn, warmup, wall_s, cpu_s, load, stage_s
frame      the same of a whole frame, drawn, where samples are taken without drawing
subject    subject, status, reason, check, counters, footprint, traffic, quality, exact, frame_reason, driver, facts
end        others, seconds, cut                       the group is whole; cut: it took fewer samples than it should, for
                                                      want of time, and is measured anew on resume
superseded                                            an attempt was cut short; its rows no longer count
limits     fill, copy, multiply-add rates of the device
```
Rows are only ever appended. A group counts once its `end` is there; until then it runs again on resume.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lodbench.datasets_gen.files import write_file
from lodbench.harness.record.foreign import RUN_FIELDS, read_json, refuse_links
from lodbench.harness.record.samples import SAMPLES, Writer, plain, read_rows, rows_file

__all__ = [
    "GroupRecord", "RUN", "RunRecord", "SAMPLES", "SCHEMA", "SubjectRecord", "Writer", "attempts", "config_hash",
    "plain", "read_rows", "read_run", "write_json",
]  # fmt: skip

SCHEMA = 1
RUN = "run.json"


def config_hash(config: Any) -> str:
    """A short name for a configuration: the same on every machine and in every process."""
    text = json.dumps(plain(config), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def write_json(path: Path, value: Any) -> None:
    """Write `value` whole or not at all."""
    write_file(path, json.dumps(plain(value), indent=1, allow_nan=False) + "\n")


@dataclass
class SubjectRecord:
    """All that was recorded of one subject of a group; `samples` leaves out warm-ups."""

    label: str
    system: str = ""
    status: str = "failed"
    reason: str = "no result was recorded"
    params: Mapping[str, Any] = field(default_factory=dict)
    phases: dict[str, float] = field(default_factory=dict)
    from_cache: dict[str, bool] = field(default_factory=dict)
    memory_growth_bytes: int | None = None
    read_back_s: float | None = None
    peak_growth_bytes: int | None = None
    check: dict[str, Any] | None = None
    counters: dict[str, Any] = field(default_factory=dict)
    footprint: dict[str, Any] = field(default_factory=dict)
    traffic: dict[str, dict[str, int]] = field(default_factory=dict)
    quality: dict[str, Any] | None = None
    exact: dict[str, dict[str, Any]] = field(default_factory=dict)
    samples: list[dict[str, Any]] = field(default_factory=list)
    warmups: list[dict[str, Any]] = field(default_factory=list)
    frames: list[dict[str, Any]] = field(default_factory=list)
    frame_reason: str = ""
    driver: str = ""

    @property
    def frame_s(self) -> dict[int, float]:
        """Turn -> wall seconds of the whole frames that were drawn apart from the samples."""
        return {row["turn"]: row["wall_s"] for row in self.frames}

    @property
    def path_s(self) -> dict[int, list[float]]:
        """Step of the camera path -> wall seconds of its whole frames; nothing without a path."""
        found: dict[int, list[float]] = {}
        for row in self.frames:
            if "step" in row:
                found.setdefault(row["step"], []).append(row["wall_s"])
        return found

    @property
    def wall_s(self) -> dict[int, float]:
        """Turn -> wall seconds of the counted samples."""
        return {row["turn"]: row["wall_s"] for row in self.samples}

    @property
    def stages(self) -> list[str]:
        """Stage names in the order in which they ran."""
        return list(dict.fromkeys(name for row in self.samples for name in row["stage_s"]))

    def stage_by_turn(self, name: str) -> dict[int, float]:
        """Turn -> seconds of one stage, of the counted samples that have it."""
        return {row["turn"]: row["stage_s"][name] for row in self.samples if name in row["stage_s"]}

    def stage_s(self, *names: str) -> list[float]:
        """Per counted sample, the seconds of these stages together; of all stages when none is named."""
        return [
            sum(s for name, s in row["stage_s"].items() if not names or name in names)
            for row in self.samples
        ]


@dataclass
class GroupRecord:
    """One whole interleaved group: its subjects by label, in the order in which they took turns."""

    group: str
    table: str
    name: str
    dataset: str
    device: str
    facts: dict[str, Any]
    config: dict[str, Any]
    others: float = 0.0
    seconds: float = 0.0
    subjects: dict[str, SubjectRecord] = field(default_factory=dict)


@dataclass
class RunRecord:
    """A run as it was recorded: the environment, the whole groups, and the device's measured limits."""

    folder: Path
    environment: dict[str, Any]
    groups: list[GroupRecord]
    limits: dict[str, Any] | None = None

    def of_table(self, table: str) -> list[GroupRecord]:
        """The groups of one table, in the order of its definition."""
        return [group for group in self.groups if group.table == table]

    @property
    def tables(self) -> list[str]:
        """Tables that have a whole group."""
        return list(dict.fromkeys(group.table for group in self.groups))


_SUBJECT_FIELDS = (
    "status", "reason", "check", "counters", "footprint", "traffic", "quality", "read_back_s",
    "peak_growth_bytes", "frame_reason", "driver", "exact",
)  # fmt: skip
_GROUP_FIELDS = ("group", "table", "name", "dataset", "device", "facts", "config")
_SETUP_FIELDS = ("system", "params", "phases", "from_cache", "memory_growth_bytes")


def read_environment(folder: Path) -> dict[str, Any]:
    """The content of `run.json`.

    Raises:
        ValueError: broken, or of another schema.
    """
    path = folder / RUN
    schema = read_json(path, {"schema": int})["schema"]
    if schema != SCHEMA:
        raise ValueError(f"{path}: expected schema {SCHEMA}, got {schema}")
    return read_json(path, RUN_FIELDS)


def read_run(folder: Path) -> RunRecord:
    """The record in a run's folder.

    Raises:
        ValueError: not a run's folder, or one of another schema.
    """
    folder = Path(folder)
    if not (folder / RUN).is_file():
        raise ValueError(f"run: expected a folder with {RUN}, got {folder}")
    refuse_links(folder)
    environment = read_environment(folder)
    path = rows_file(folder)
    rows = read_rows(path) if path.exists() else []
    open_groups: dict[tuple[str, int], GroupRecord] = {}
    whole: dict[str, GroupRecord] = {}
    limits = None
    for row in rows:
        kind = row["kind"]
        if kind == "limits":
            limits = {key: value for key, value in row.items() if key != "kind"}
            continue
        key = (row["group"], row["attempt"])
        if kind == "begin":
            group = GroupRecord(**{name: row[name] for name in _GROUP_FIELDS})
            for subject in group.config.get("subjects", []):  # the order is that of the definition
                group.subjects[subject["label"]] = SubjectRecord(
                    subject["label"], subject["system"]
                )
            open_groups[key] = group
        elif kind == "superseded":
            open_groups.pop(key, None)
        elif key in open_groups:
            _add(open_groups[key], row)
            if kind == "end":
                whole[row["group"]] = open_groups.pop(key)
    return RunRecord(folder, environment, list(whole.values()), limits)


def _add(group: GroupRecord, row: dict[str, Any]) -> None:
    if row["kind"] == "end":
        group.others, group.seconds = row["others"], row.get("seconds") or 0.0
        return
    label = row["subject"]
    subject = group.subjects.setdefault(label, SubjectRecord(label))
    if row["kind"] == "sample":
        (subject.warmups if row["warmup"] else subject.samples).append(row)
    if row["kind"] == "frame":
        subject.frames.append(row)
    names = _SUBJECT_FIELDS if row["kind"] == "subject" else _SETUP_FIELDS
    for name in names:
        if name in row:
            setattr(subject, name, row[name])


def attempts(folder: Path) -> tuple[set[str], dict[str, list[int]]]:
    """(hashes of whole groups, hash -> attempts that were begun and neither ended, uncut, nor superseded)."""
    path = rows_file(folder)
    ended: set[str] = set()
    begun: dict[str, list[int]] = {}
    for row in read_rows(path) if path.exists() else []:
        if row["kind"] == "begin":
            begun.setdefault(row["group"], []).append(row["attempt"])
        elif row["kind"] == "superseded" or (row["kind"] == "end" and not row.get("cut")):
            open_attempts = begun.get(row["group"], [])
            if row["attempt"] in open_attempts:
                open_attempts.remove(row["attempt"])
            if row["kind"] == "end":
                ended.add(row["group"])
    return ended, begun
