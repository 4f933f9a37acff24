"""A sweep over machines: by a cluster made up for the test, and over real processes of which one is killed."""

import collections
import os
import signal
import threading
import time

import pytest

from lodbench.harness.cli.app import main
from lodbench.harness.measure import remote, spread
from lodbench.harness.measure.cluster import Lost, connected
from lodbench.harness.measure.identity import config_of
from lodbench.harness.measure.spread import Spread
from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.record.environment import commit
from lodbench.harness.record.record import Writer, config_hash, read_rows, read_run
from lodbench.harness.record.samples import rows_file
from tests.fuzz.faults import doubled
from tests.harness import fake

SETTINGS = {"samples": 3, "precision": 0.05, "seed": 0}
GROUPS = [("t", Group(name, (Subject("fake"), Subject("other")))) for name in fake.DATASETS]
RATES = {
    "device": "d",
    "size_bytes": 1,
    **dict.fromkeys(("fill", "copy", "multiply_add"), fake._RATE),
}


def environment(slug="dev", cores=2, code=None):
    return {
        "started": "now", "commit": code or commit()[0], "slug": slug, "options": {}, "seed": 0,
        "device": {"name": slug, "platform": "p", "kind": "cpu"}, "machine": {"cpu": "c", "cores": cores},
    }  # fmt: skip


def rows_of(group):
    ids = {"group": "theirs", "attempt": 0}
    yield {
        "kind": "begin", **ids, "table": "t", "name": group.name, "dataset": group.dataset, "device": "dev",
        "facts": {"dataset": group.dataset}, "config": {},
    }  # fmt: skip
    for subject in group.subjects:
        yield {"kind": "subject", **ids, "subject": subject.name, "status": "ok", "reason": ""}
    yield {"kind": "end", **ids, "others": 0.0}


class Machines:
    """Workers (address -> host) whose jobs are done at once, or end as `loses` says: dataset -> times lost."""

    def __init__(self, workers, devices=None, loses=None):
        self.found, self.devices = workers, devices or {}
        self.loses = collections.Counter(loses or {})
        self.asked, self.at_once = [], collections.Counter()

    def workers(self):
        return dict(self.found)

    def submit(self, address, function, *arguments):
        self.asked.append((address, function, arguments))
        self.at_once[self.found[address]] += 1
        assert self.at_once[self.found[address]] == 1, "two at a time on one machine"
        return len(self.asked) - 1

    def done(self, futures):
        for future in list(futures):
            address, function, arguments = self.asked[future]
            self.at_once[self.found[address]] -= 1
            if function is remote.describe:
                yield future, self.devices.get(address, [environment()])
            elif function is remote.rates:
                yield future, RATES
            elif self.loses[arguments[2].dataset] > 0:
                self.loses[arguments[2].dataset] -= 1
                yield future, Lost()
            else:
                yield future, (list(rows_of(arguments[2])), True)

    def cancel(self, futures):
        pass

    def send_anew(self):
        pass


@pytest.fixture
def sent(monkeypatch, tmp_path):
    """Measures GROUPS on some machines into a folder."""
    fake.install(monkeypatch.setattr)
    monkeypatch.setattr(spread, "WAIT_S", 0.0)
    monkeypatch.setattr(spread, "POLL_S", 0.0)

    def measure(machines, devices=(None,), resume=False, budget=None):
        return Spread(
            machines, GROUPS, devices, arguments=SETTINGS, options={}, out=tmp_path / "run", resume=resume,
            time_budget_s=budget, quiet=True,
        ).measure()  # fmt: skip

    return measure


def test_each_group_is_measured_once_and_one_at_a_time_on_a_machine(sent):
    machines = Machines({"a1": "a", "a2": "a", "b": "b"})
    ((folder, left_out),) = sent(machines)
    run = read_run(folder)
    assert sorted(group.dataset for group in run.groups) == sorted(fake.DATASETS)
    assert run.limits is not None and not left_out
    measured = [address for address, function, _ in machines.asked if function is remote.measure]
    assert len(measured) == 3 and {machines.found[address] for address in measured} == {"a", "b"}


def test_group_of_a_worker_that_is_gone_is_measured_elsewhere_and_no_row_doubled(sent):
    ((folder, _),) = sent(Machines({"a": "a", "b": "b"}, loses={"two": 2}))
    assert len(read_run(folder).groups) == 3
    assert doubled(read_rows(rows_file(folder))) == []


def test_group_over_which_every_worker_dies_is_a_failed_row_and_the_sweep_goes_on(sent):
    ((folder, _),) = sent(Machines({"a": "a"}, loses={"two": 9}))
    status = {
        group.dataset: {subject.status for subject in group.subjects.values()}
        for group in read_run(folder).groups
    }
    assert status == {"one": {"ok"}, "two": {"failed"}, "three": {"ok"}}


def test_machines_that_differ_have_a_folder_each_with_the_whole_sweep(sent):
    machines = Machines({"a": "a", "b": "b"}, {"b": [environment(cores=64)]})
    folders = [folder for folder, _ in sent(machines)]
    assert [folder.name for folder in folders] == ["device-0", "device-1"]
    assert [len(read_run(folder).groups) for folder in folders] == [3, 3]


def test_several_devices_of_a_machine_are_measured_one_after_the_other(sent):
    machines = Machines({"a": "a"}, {"a": [environment("one"), environment("two")]})
    found = sent(machines, ("one", "two"))
    assert [read_run(folder).environment["slug"] for folder, _ in found] == ["one", "two"]
    assert all(len(read_run(folder).groups) == 3 for folder, _ in found)


def test_resume_measures_what_is_lacking_and_supersedes_what_was_begun(sent):
    ((folder, left_out),) = sent(Machines({"a": "a"}), budget=-1.0)
    assert len(left_out) == 3 and not read_run(folder).groups
    writer = Writer(folder)
    key = config_hash(config_of("t", GROUPS[0][1], "dev", 3, 0.05, 0))
    writer.write(**{**next(rows_of(GROUPS[0][1])), "group": key})
    writer.close()
    sent(Machines({"a": "a"}), resume=True)
    assert len(read_run(folder).groups) == 3
    attempts = {r["attempt"] for r in read_rows(rows_file(folder)) if r.get("group") == key}
    assert attempts == {0, 1}
    again = Machines({"a": "a"})
    sent(again, resume=True)
    assert not [one for one in again.asked if one[1] is remote.measure]


def test_what_cannot_be_used_is_said_in_one_line(sent):
    with pytest.raises(ValueError, match="resource lodbench, got none: start one on each machine"):
        sent(Machines({}))
    with pytest.raises(ValueError, match=r"expected workers with commit .*, got abc at a"):
        sent(Machines({"a": "a"}, {"a": [environment(code="abc")]}))
    with pytest.raises(ValueError, match="no worker has the device gpu: none here"):
        sent(Machines({"a": "a"}, {"a": ["none here"]}), ("gpu",))


def test_scheduler_that_does_not_answer_is_said_in_one_line(monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("lodbench.harness.measure.cluster.CONNECT_S", 0.2)
    with (
        pytest.raises(ValueError, match="dask: expected a scheduler's address"),
        connected("tcp://127.0.0.1:1"),
    ):
        pass


SWEEP = """
name = "grids"
systems = ["quadric_clustering", "numpy_quadric_clustering"]
datasets = ["torus_2k", "own.ply"]
[params]
cells = [8, 10, 12, 14]
"""


def kill_one_at_work(client, seen):
    """Kill the first worker that is seen to measure."""
    pids = client.run(os.getpid)
    until = time.monotonic() + 120
    while time.monotonic() < until:
        for address, tasks in client.processing().items():
            if any("measure" in str(task) for task in tasks):
                os.kill(pids[address], signal.SIGKILL)
                seen.append(address)
                return
        time.sleep(0.02)


@pytest.mark.slow
def test_sweep_over_real_processes_survives_the_death_of_one(tmp_path, capsys):
    distributed = pytest.importorskip("distributed")
    from lodbench.datasets_gen.read import write_mesh
    from lodbench.datasets_gen.triangles import icosphere

    write_mesh(tmp_path / "own.ply", icosphere(4))
    (tmp_path / "grids.toml").write_text(SWEEP)
    out, seen = tmp_path / "run", []
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None,
            resources={"lodbench": 1},
        ) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
    ):  # fmt: skip
        killer = threading.Thread(target=kill_one_at_work, args=(client, seen))
        killer.start()
        words = ["sweep", tmp_path / "grids.toml", "--dask", cluster.scheduler_address]
        code = main([*map(str, [*words, "--out", out]), "--samples", "3", "-q"])
        killer.join()
    assert code == 0, capsys.readouterr().err
    assert seen, "no worker was killed"
    rows = read_rows(rows_file(out))
    assert doubled(rows) == []
    groups = read_run(out).groups
    assert len(groups) == 8
    assert all(len(subject.samples) == 3 for group in groups for subject in group.subjects.values())
