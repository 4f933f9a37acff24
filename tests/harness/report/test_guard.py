"""What got slower relative to NumPy or to copying memory, whatever the machine."""

from types import SimpleNamespace

import numpy as np
import pytest

from lodbench.harness.cli.app import main
from lodbench.harness.plan import registry
from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.plan.table import Table
from lodbench.harness.report import derive, guard
from tests.harness import fake
from tests.harness.records import group, run, subject


@pytest.fixture(autouse=True)
def systems(monkeypatch):
    known = {
        name: SimpleNamespace(runs_on=where)
        for name, where in (("ours", "device"), ("slowed", "device"), ("numpy_ours", "host"), ("rival", "host"))
    }  # fmt: skip
    monkeypatch.setattr(registry, "registry", lambda: registry.Registry(known))


def made(seed=0, machine=1.0, change=1.0, plain=True, copy=1e10, others=0.0):
    """A run on a machine that takes `machine` times as long for everything; `change` is that of one kernel."""
    rng = np.random.default_rng(seed)

    def times(seconds):
        return list(machine * seconds * rng.lognormal(sigma=0.03, size=40))

    subjects = [
        subject("ours", times(1e-3)),
        subject("slowed", times(2e-3 * change)),
        subject("rival", times(5e-2)),
    ]
    if plain:
        subjects.append(subject("numpy_ours", times(2e-2)))
    found = run(group(*subjects, dataset="d", others=others))
    found.environment |= {"machine": {"cpu": "y"}, "started": f"2020-01-0{seed + 1}", "options": {}}
    found.limits = {"copy": {"median": copy / machine}}
    return found


def verdicts(before, after):
    return {row["system"]: (row["verdict"], row["against"]) for row in guard.judged(before, after)}


@pytest.mark.parametrize(("plain", "against"), [(True, "numpy_ours"), (False, "copying memory")])
@pytest.mark.parametrize("machine", [1.0, 3.0, 0.4])
def test_another_machine_is_no_slowdown_and_a_slower_kernel_is(machine, plain, against):
    before = made(0, plain=plain)
    assert verdicts(before, made(1, machine, plain=plain)) == {
        "ours": ("same", against),
        "slowed": ("same", against),
    }
    assert verdicts(before, made(1, machine, change=1.4, plain=plain)) == {
        "ours": ("same", against),
        "slowed": ("regression", against),
    }


def test_time_on_a_busy_machine_says_nothing_but_results_do():
    after = made(1, change=3.0, others=0.3)
    assert verdicts(made(0), after)["slowed"] == ("busy", "numpy_ours")
    after.groups[0].subjects["slowed"].counters = {"triangles": 3}
    before = made(0)
    before.groups[0].subjects["slowed"].counters = {"triangles": 4}
    (row,) = (row for row in guard.judged(before, after) if row["system"] == "slowed")
    assert (row["verdict"], row["why"]) == ("regression", "triangles 4 -> 3")


def test_relative_times_are_taken_turn_by_turn():
    both = group(subject("ours", [1.0, 2.0, 3.0]), subject("numpy_ours", [2.0, 4.0, 6.0]))
    assert guard.relative(run(both), both, both.subjects["ours"]) == [0.5, 0.5, 0.5]
    assert guard.relative(run(both), both, both.subjects["numpy_ours"]) == []


def test_choice_is_the_quickest_case_of_each_table_whose_frames_are_no_mere_launches(monkeypatch):
    fake_groups = {"a": ("one", "two"), "b": ("one", "two", "three")}
    monkeypatch.setattr(Group, "found", lambda self: SimpleNamespace(name=self.dataset, content=""))

    def table(name):
        groups = [Group(dataset, (Subject("ours"),)) for dataset in fake_groups[name]]
        return Table(name, name, "nobody", lambda quick: groups, ())

    monkeypatch.setattr(derive, "tables_of", lambda run: [table(name) for name in run.tables])

    def recorded(name, dataset, seconds, frame):
        found = group(subject("ours", [frame] * 10), table=name, dataset=dataset)
        found.name, found.seconds = dataset, seconds
        return found

    old = run(
        recorded("a", "one", 1.0, 1e-5), recorded("a", "two", 4.0, 1e-2), recorded("b", "one", 9.0, 1e-2),
        recorded("b", "two", 8.0, 1e-2), recorded("b", "gone", 1.0, 1e-2),
    )  # fmt: skip
    old.environment["options"] = {}
    names = {
        seconds: [
            (table.id, [g.name for g in table.groups(False)])
            for _, tables in guard.chosen([old], seconds) for table in tables
        ]
        for seconds in (0, 4, 12)
    }  # fmt: skip
    assert names == {0: [("a", ["two"])], 4: [("a", ["two"])], 12: [("a", ["two"]), ("b", ["two"])]}


def test_no_recorded_run_is_named(tmp_path):
    with pytest.raises(ValueError, match="reference: expected a folder with recorded runs, got"):
        guard.recorded(tmp_path)


def test_command_measures_what_was_recorded_and_compares(tmp_path, monkeypatch, capfd):
    with monkeypatch.context() as patch:
        fake.install(patch.setattr)
        folder = tmp_path / "recorded"
        assert main(["reproduce", "--samples", "8", "-q", "--out", str(folder)]) == 0
        capfd.readouterr()
        code = main(["guard", "--reference", str(folder), "-q", "--seconds", "0"])
        said = capfd.readouterr()
    # fakes run on the host: there is nothing to say of them
    assert (code, said.err.count("\n")) == (2, 1)
    assert said.err.startswith("error: reference: expected rows of a device in both runs, got none")
