"""Groups measured by the workers of a Dask cluster: one at a time on each machine, each recorded once.

A group is whole on one machine, where its subjects take turns as ever; its rows come back when it is done and are
written here. So a worker that dies leaves no row, and its group goes to another. Machines of one kind (device,
processor, cores) share the groups; each kind has a folder of its own, since nothing is compared across kinds.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from lodbench.harness.measure import remote
from lodbench.harness.measure.alike import Kind, alike
from lodbench.harness.measure.cluster import POLL_S, RESOURCE, START, Cluster, Lost
from lodbench.harness.measure.progress import Progress
from lodbench.harness.plan.group import Group
from lodbench.harness.record.environment import commit
from lodbench.harness.record.samples import pack

MOST_DEATHS = 3  # of workers over one group: then it failed
WAIT_S = 60.0  # for a worker, while there is none
Work = Sequence[tuple[str, Group]]


class _Machine(NamedTuple):
    host: str
    devices: list[dict[str, Any] | str]  # by name asked for: an environment, or why there is none


class _Job(NamedTuple):
    address: str
    host: str
    kind: Kind | None  # none: a worker says what it has
    table: str = ""
    group: Group | None = None  # none: the kind's limits


class Spread:
    """A sweep over the machines of a cluster.

    Args:
        cluster: where.
        work: (table id, group) of all that is measured.
        devices: names, each measured wherever a machine has it; None is a machine's default.
        arguments: of a `Session`: samples, precision, seed.
        options: kept in each folder's `run.json`.
        out: the folder, or that of one folder for each kind where there are several.
        resume: go on with what is there.
        time_budget_s: no group is begun after it.
        quiet: no progress.

    Raises:
        ValueError: no worker may be used, or one has other code.
    """

    def __init__(
        self, cluster: Cluster, work: Work, devices: Sequence[str | None], *, arguments: Mapping[str, Any],
        options: Mapping[str, Any], out: Path | None, resume: bool, time_budget_s: float | None, quiet: bool,
    ) -> None:  # fmt: skip
        self._cluster, self._work, self._names = cluster, work, list(devices)
        self._arguments, self._options = dict(arguments), dict(options)
        self._out, self._resume, self._quiet = out, resume, quiet
        self._until = None if time_budget_s is None else time.monotonic() + time_budget_s
        self._machines: dict[str, _Machine] = {}
        self._kinds: list[Kind] = []
        self._jobs: dict[Any, _Job] = {}

    def measure(self) -> list[tuple[Path, list[str]]]:
        """Measure all of it; each kind's folder, and the groups for which there was no time."""
        try:
            self._meet()
            self._open()
            with Progress(len(self._work) * len(self._kinds), self._quiet) as progress:
                self._run(progress)
        finally:
            self._cluster.cancel(self._jobs)
            for kind in self._kinds:
                kind.close()
        for kind in self._kinds:
            if not kind.left_out:
                pack(kind.folder)
        return [(kind.folder, kind.left_out) for kind in self._kinds]

    def _submit(self, job: _Job, function: Any, *arguments: Any) -> None:
        self._jobs[self._cluster.submit(job.address, function, *arguments)] = job

    def _meet(self) -> None:
        """Ask the workers that are there what devices they have."""
        until = time.monotonic() + WAIT_S
        while not (workers := self._cluster.workers()):
            if time.monotonic() > until:
                raise ValueError(
                    f"dask: expected workers with the resource {RESOURCE}, got none: start one on each machine by "
                    f"`{START}`"
                )
            time.sleep(POLL_S)
        while not set(workers) <= set(self._machines):
            self._ask(workers)
            self._collect()
            workers = self._cluster.workers()
        found: dict[tuple[Any, ...], Kind] = {}
        for machine in self._machines.values():
            for number, said in enumerate(machine.devices):
                if not isinstance(said, str):
                    found.setdefault(alike(number, said), Kind(number, said, self._arguments))
        self._kinds = [kind for _, kind in sorted(found.items())]
        for number, name in enumerate(self._names):
            if not any(kind.device == number for kind in self._kinds):
                reasons = sorted(
                    {str(machine.devices[number]) for machine in self._machines.values()}
                )
                raise ValueError(
                    f"dask: no worker has the device {name or 'asked for'}: {'; '.join(reasons)}"
                )

    def _ask(self, workers: Mapping[str, str]) -> None:
        """A new worker is asked what it has, while nothing is measured on its machine."""
        busy = {job.host for job in self._jobs.values()}
        for address, host in workers.items():
            if address not in self._machines and host not in busy:
                busy.add(host)
                self._submit(_Job(address, host, None), remote.describe, self._names)

    def _open(self) -> None:
        for number, kind in enumerate(self._kinds):
            out = self._out
            if out is not None and len(self._kinds) > 1:
                out = out / f"device-{number}"
            kind.open(out, self._resume, self._options, self._work)

    def _run(self, progress: Progress) -> None:
        left = sum(group is not None for kind in self._kinds for _, group in kind.pending)
        progress.advance(len(self._work) * len(self._kinds) - left, kept=True)
        alone_since = None
        while self._jobs or any(kind.pending for kind in self._kinds):
            workers = self._cluster.workers()
            self._lose(set(self._jobs[future].address for future in self._jobs) - set(workers))
            if self._until is not None and time.monotonic() > self._until:
                self._leave_out()
            self._ask(workers)
            self._hand_out(workers, progress)
            idle = any(kind.pending for kind in self._kinds) and not self._jobs
            alone_since = (alone_since or time.monotonic()) if idle else None
            if alone_since and time.monotonic() - alone_since > WAIT_S:
                folders = " ".join(str(kind.folder) for kind in self._kinds)
                raise ValueError(
                    f"dask: expected a worker for what is left, got none for {WAIT_S:.0f} s; what was measured is "
                    f"kept in {folders}: go on with --resume"
                )
            progress.advance(len(self._collect()))

    def _hand_out(self, workers: Mapping[str, str], progress: Progress) -> None:
        """A job for each machine that has none: several workers of one machine take turns."""
        busy = {job.host for job in self._jobs.values()}
        for address, host in workers.items():
            if host in busy or address not in self._machines:
                continue
            for kind in self._kinds:
                said = self._machines[address].devices[kind.device]
                if not kind.pending or isinstance(said, str):
                    continue
                if alike(kind.device, said) != kind.key:
                    continue
                table, group = kind.pending.popleft()
                name = self._names[kind.device]
                job = _Job(address, host, kind, table, group)
                if group is None:
                    self._submit(job, remote.rates, name)
                else:
                    progress.task(f"{table}: {group.name} on {host}")
                    self._submit(
                        job, remote.measure, name, table, group, self._session(), self._file(group)
                    )
                busy.add(host)
                break

    def _session(self) -> dict[str, Any]:
        left = None if self._until is None else max(self._until - time.monotonic(), 0.1)
        return {**self._arguments, "time_budget_s": left}

    def _file(self, group: Group) -> Any:
        """Of a dataset that is a file of one's own, its bytes on their way; else None."""
        dataset = group.found()
        return (
            self._cluster.send(Path(dataset.source), dataset.content) if dataset.content else None
        )

    def _leave_out(self) -> None:
        for kind in self._kinds:
            kind.left_out += [
                f"{table}: {group.name}" for table, group in kind.pending if group is not None
            ]
            kind.pending.clear()

    def _lose(self, addresses: set[str]) -> None:
        """Workers are gone: what they were at goes to others."""
        for future, job in list(self._jobs.items()):
            if job.address in addresses:
                del self._jobs[future]
                self._cluster.cancel([future])
                self._cluster.send_anew()
                self._again(job)

    def _again(self, job: _Job) -> None:
        if job.kind is None:
            return
        if job.group is not None:
            key = job.kind.hash(job.table, job.group)
            job.kind.deaths[key] = job.kind.deaths.get(key, 0) + 1
            if job.kind.deaths[key] >= MOST_DEATHS:
                job.kind.fail(job.table, job.group, f"its worker died, {MOST_DEATHS} times")
                return
        job.kind.pending.appendleft((job.table, job.group))

    def _collect(self) -> list[Group]:
        """Wait a moment and take what is done; the groups that are."""
        found = []
        for future, result in self._cluster.done(self._jobs):
            job = self._jobs.pop(future)
            if isinstance(result, Lost):
                self._again(job)
            elif job.kind is None:
                self._know(job, result)
            elif job.group is None:
                job.kind.note(**result)
            else:
                rows, whole = result
                job.kind.write(job.table, job.group, rows)
                found.append(job.group)
                if not whole:
                    job.kind.left_out.append(f"{job.table}: {job.group.name}")
        return found

    def _know(self, job: _Job, devices: list[dict[str, Any] | str]) -> None:
        short, _ = commit()
        for said in devices:
            if not isinstance(said, str) and said["commit"] != short:
                raise ValueError(
                    f"dask: expected workers with commit {short}, got {said['commit']} at {job.address}"
                )
        self._machines[job.address] = _Machine(job.host, devices)
