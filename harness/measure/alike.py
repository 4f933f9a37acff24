"""Machines of a cluster that are alike, and the folder of what is measured on them."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lodbench.harness.measure.identity import config_of
from lodbench.harness.plan.group import Group
from lodbench.harness.record.folder import open_described
from lodbench.harness.record.record import Writer, attempts, config_hash, read_run


def alike(device: int, environment: Mapping[str, Any]) -> tuple[Any, ...]:
    """What machines of one kind have in common: which of the devices asked for, its name, processor and cores."""
    machine = environment["machine"]
    return device, environment["slug"], str(machine["cpu"]), machine["cores"] or 0


@dataclass
class Kind:
    """Machines that are alike, and what is left to be measured on them.

    Attributes:
        device: number of the name asked for.
        environment: of the first of these machines.
        arguments: of a `Session`: samples, precision, seed.
        pending: (table id, group); no group: the device's limits.
        left_out: names of groups for which there was no time.
        deaths: of workers, by group.
    """

    device: int
    environment: dict[str, Any]
    arguments: Mapping[str, Any]
    folder: Path = Path()
    pending: deque[tuple[str, Group | None]] = field(default_factory=deque)
    left_out: list[str] = field(default_factory=list)
    deaths: dict[str, int] = field(default_factory=dict)
    _writer: Writer | None = None
    _begun: dict[str, list[int]] = field(default_factory=dict)

    @property
    def key(self) -> tuple[Any, ...]:
        return alike(self.device, self.environment)

    def open(
        self,
        out: Path | None,
        resume: bool,
        options: Mapping[str, Any],
        work: Iterable[tuple[str, Group]],
    ) -> None:
        """Make or take up the folder; what it lacks of `work` is pending."""
        about = {**self.environment, "options": dict(options), "seed": self.arguments["seed"]}
        self.folder = open_described(about, out=out, resume=resume)
        self._writer = Writer(self.folder)
        ended, self._begun = attempts(self.folder)
        if read_run(self.folder).limits is None:
            self.pending.append(("", None))
        self.pending += [one for one in work if self.hash(*one) not in ended]

    def close(self) -> None:
        if self._writer is not None:
            self._writer.close()

    def _config(self, table: str, group: Group) -> dict[str, Any]:
        given = self.arguments
        return config_of(
            table, group, self.environment["slug"], given["samples"], given["precision"], given["seed"],
        )  # fmt: skip

    def hash(self, table: str, group: Group) -> str:
        """The name of a group's configuration here."""
        return config_hash(self._config(table, group))

    def note(self, **row: Any) -> None:
        """The row of the device's limits."""
        assert self._writer is not None
        self._writer.write("limits", **row)

    def write(self, table: str, group: Group, rows: Sequence[Mapping[str, Any]]) -> None:
        """A group's rows, made elsewhere, as the next attempt at it."""
        assert self._writer is not None
        config = self._config(table, group)
        key = config_hash(config)
        earlier = self._begun.pop(key, [])
        for attempt in earlier:
            self._writer.write("superseded", group=key, attempt=attempt)
        ours = {"group": key, "attempt": max(earlier, default=-1) + 1}
        for row in rows:
            more = {"config": config} if row["kind"] == "begin" else {}
            self._writer.write(**{**row, **ours, **more})

    def fail(self, table: str, group: Group, reason: str) -> None:
        """The group cannot be measured: each of its subjects failed."""
        dataset = group.found()
        facts = {**group.facts, "dataset": dataset.name, "standin": dataset.standin}
        begin = {
            "kind": "begin", "table": table, "name": group.name, "dataset": dataset.name, "facts": facts,
            "device": self.environment["slug"],
        }  # fmt: skip
        failed = [
            {"kind": "subject", "subject": subject.name, "status": "failed", "reason": reason}
            for subject in group.subjects
        ]
        self.write(table, group, [begin, *failed, {"kind": "end", "others": 0.0}])
