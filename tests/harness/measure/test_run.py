import dataclasses
import os
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.finest import finest
from lodbench.datasets_gen.nurbs import ball
from lodbench.datasets_gen.patches import cup
from lodbench.harness.measure.run import Session
from lodbench.harness.plan import registry
from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.record import lock, record
from lodbench.harness.record.folder import open_folder
from lodbench.harness.record.record import read_rows, read_run
from lodbench.harness.report.document import document
from lodbench.kernels.stages.paths import CameraPath
from tests.harness import fake


@pytest.fixture
def folder(tmp_path, device, monkeypatch):
    fake.install(monkeypatch.setattr)
    return open_folder(device, {}, out=tmp_path / "run")


def measure(device, folder, *groups, **options):
    session = Session(device, folder, samples=2, **options)
    try:
        return session.measure([("t", group) for group in groups], quiet=True)
    finally:
        session.close()


def subjects(folder):
    (group,) = read_run(folder).of_table("t")
    return group.subjects


def test_group_is_recorded_with_phases_samples_check_and_counts(device, folder):
    measure(device, folder, Group("one", (Subject("fake"),), {"cells": 3}))
    (group,) = read_run(folder).groups
    assert (group.dataset, group.facts["cells"], group.facts["triangles_in"]) == ("one", 3, 4)
    found = group.subjects["fake"]
    assert (found.status, found.reason) == ("ok", "")
    assert {"build", "prepare"} <= set(found.phases)
    assert found.check["passed"]
    assert found.counters["triangles"] == 4
    assert found.footprint["stored_bytes"] == 48
    assert found.traffic["call"]["bytes"] == 48
    assert (len(found.warmups), len(found.samples)) == (3, 2)
    assert all(row["stage_s"]["call"] >= 0 for row in found.samples)


def test_subjects_take_turns(device, folder):
    measure(device, folder, Group("one", (Subject("fake"), Subject("other"))))
    rows = read_rows(folder / record.SAMPLES)
    counted = [r["subject"] for r in rows if r["kind"] == "sample" and not r["warmup"]]
    assert counted == ["fake", "other"] * 2


@pytest.mark.parametrize(
    ("outcome", "status", "reason"),
    [
        ("unsupported", "skipped", "needs wings, device has none"),
        ("missing", "skipped", "No module named 'wings'"),
        ("memory", "skipped", "needs more memory than the host has: 3 GB for corners"),
        ("crash", "failed", "DeviceError: a command failed"),
        ("late crash", "failed", "DeviceError: a command failed"),
        ("wrong", "failed", "check: difference is 1, tolerance 0.5"),
    ],
)
def test_one_subject_ends_and_the_others_go_on(device, folder, outcome, status, reason):
    bad = Subject("fake", {"outcome": outcome}, "bad")
    measure(device, folder, Group("one", (bad, Subject("other"))))
    found = subjects(folder)
    assert (found["bad"].status, found["bad"].reason) == (status, reason)
    assert found["other"].status == "ok"
    assert len(found["other"].samples) == 2


def test_system_that_cannot_be_imported_is_recorded_as_skipped(device, folder):
    measure(device, folder, Group("one", (Subject("gone"), Subject("fake"))))
    assert (subjects(folder)["gone"].status, subjects(folder)["gone"].reason) == (
        "skipped",
        "no package",
    )


def test_params_may_depend_on_what_an_earlier_subject_made(device, folder):
    def twice(context):
        return {"size": 2 * context.counters["fake"]["triangles"]}

    measure(device, folder, Group("one", (Subject("fake", {"size": 3}), Subject("other", twice))))
    assert subjects(folder)["other"].params["size"] == 24


def test_fault_of_the_program_is_not_hidden_and_the_group_runs_again(device, folder):
    def broken(context):
        raise KeyError("oops")

    with pytest.raises(KeyError):
        measure(device, folder, Group("one", (Subject("fake"), Subject("other", broken))))
    assert read_run(folder).groups == []


def test_whole_groups_are_measured_once(device, folder):
    groups = [Group("one", (Subject("fake"),)), Group("two", (Subject("fake"),))]
    measure(device, folder, groups[0])
    size = (folder / record.SAMPLES).stat().st_size
    measure(device, folder, groups[0])
    assert (folder / record.SAMPLES).stat().st_size == size
    measure(device, folder, *groups)
    assert [group.dataset for group in read_run(folder).groups] == ["one", "two"]


def test_spent_time_budget_leaves_groups_out_and_names_them(device, folder):
    left = measure(device, folder, Group("one", (Subject("fake"),)), time_budget_s=0.0)
    assert left == ["t: one"]
    assert read_run(folder).groups == []


class Clock:
    """Seconds that pass only where a test lets them: in the fakes' set-up and frames."""

    def __init__(self, monkeypatch, prepare_s, frame_s):
        self.now = 0.0
        monkeypatch.setattr(time, "perf_counter", lambda: self.now)
        clock = self

        class Slow(fake.Fake):
            def __init__(self, *arguments):
                super().__init__(*arguments)
                clock.now += prepare_s

            def enqueue(self, *arguments):
                super().enqueue(*arguments)
                clock.now += frame_s

        slow = {n: dataclasses.replace(s, prepare=Slow) for n, s in fake.SYSTEMS.items()}
        monkeypatch.setattr(registry, "registry", lambda: registry.Registry(slow, {}))


PAIR = (Subject("fake"), Subject("other"))


@pytest.mark.parametrize("seconds", [10.0, 20.0])
@pytest.mark.parametrize(("prepare_s", "frame_s"), [(1.0, 0.1), (0.0, 0.5), (2.0, 0.0)])
def test_time_budget_is_kept(device, folder, monkeypatch, seconds, prepare_s, frame_s):
    clock = Clock(monkeypatch, prepare_s, frame_s)
    groups = [Group(name, PAIR, {"cells": n}) for n in range(9) for name in fake.DATASETS]
    session = Session(device, folder, samples=30, time_budget_s=seconds)
    clock.now += 0.1 * seconds  # the device's limits, measured before any group
    left = session.measure([("t", group) for group in groups], quiet=True)
    session.close()
    assert left
    assert clock.now <= 1.2 * seconds
    assert read_run(folder).groups, "something was measured"


@pytest.mark.parametrize("seconds", [10.0, 25.0, 40.0])
@pytest.mark.parametrize("frame_s", [4.0, 7.0])
def test_time_budget_is_kept_by_slow_frames(device, folder, monkeypatch, seconds, frame_s):
    clock = Clock(monkeypatch, 0.0, frame_s)
    group = Group("one", (Subject("fake"),))
    left = measure(device, folder, group, time_budget_s=seconds)
    assert clock.now <= 1.2 * seconds
    assert bool(left) == (
        len(subjects(folder)["fake"].samples) < 2 if read_run(folder).groups else True
    )


def test_group_cut_short_counts_for_tables_and_is_measured_anew_on_resume(
    device, folder, monkeypatch
):
    Clock(monkeypatch, 0.0, 1.0)
    group = Group("one", PAIR)
    assert measure(device, folder, group, time_budget_s=7.0) == ["t: one"]
    before = read_rows(folder / record.SAMPLES)
    assert len(subjects(folder)["fake"].samples) == 1
    assert measure(device, folder, group) == []
    after = read_rows(folder / record.SAMPLES)
    assert after[: len(before)] == before, "its samples stay"
    kinds = [row["kind"] for row in after[len(before) :]]
    assert kinds[:2] == ["superseded", "begin"]
    assert len(subjects(folder)["fake"].samples) == 2
    assert measure(device, folder, group) == []
    assert read_rows(folder / record.SAMPLES) == after, "and now it is whole"


@pytest.mark.parametrize("locks", [True, False])
def test_two_sessions_do_not_write_into_one_folder(device, folder, monkeypatch, locks):
    if not locks:  # as on Windows
        monkeypatch.setattr(lock, "fcntl", None)
    first = Session(device, folder)
    who = f".*run, which process {os.getpid()} writes to" if Path("/proc/locks").exists() else ""
    with pytest.raises(ValueError, match=rf"out: expected a folder that no other run .* got {who}"):
        Session(device, folder)
    with pytest.raises(ValueError, match="out: expected a folder that no other run"):
        open_folder(device, {}, out=folder, resume=True)
    first.close()
    open_folder(device, {}, out=folder, resume=True)
    Session(device, folder).close()


def test_note_of_a_process_that_is_gone_locks_nobody_out(device, folder, monkeypatch):
    monkeypatch.setattr(lock, "fcntl", None)
    for text in (f"{os.getpid()} 1.0", "999999999 1.0", "", "a b c"):
        (folder / lock.OWNER).write_text(text)
        Session(device, folder).close()
        assert not (folder / lock.OWNER).exists()


def test_folder_with_nothing_but_a_file_half_written_is_as_good_as_new(device, tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / ".run.json.77.part").write_text('{"sch')
    folder = open_folder(device, {}, out=tmp_path / "run")
    assert read_run(folder).groups == []


@pytest.mark.parametrize(
    ("group", "text"),
    [
        (Group("onne", (Subject("fake"),)), "dataset: expected one of"),
        (Group("one", (Subject("fak"),)), "system: expected one like fake, got 'fak'"),
        (Group("one", (Subject("fake", {"sise": 1}),)), "expected one like size, got 'sise'"),
        (Group("one", (Subject("fake", {"size": 0}),)), "size: expected at least 1, got 0"),
        (Group("one", (Subject("fake", case="x"),)), "case of fake: expected one of default"),
        (Group("one", (Subject("fake"), Subject("fake"))), "expected different labels"),
    ],
)
def test_bad_group_is_refused_before_anything_is_measured(device, folder, group, text):
    with pytest.raises(ValueError, match=text):
        measure(device, folder, Group("two", (Subject("fake"),)), group)
    assert not read_rows(folder / record.SAMPLES)


def test_wrong_subject_is_red_and_stays_out_of_ratios(device, folder, monkeypatch):
    made = fake.install(monkeypatch.setattr)
    session = Session(device, folder, samples=6)
    session.measure([(made.id, group) for group in made.groups(False)], quiet=True)
    session.close()
    rows = {
        row["system"]: row
        for row in document(made, read_run(folder))["rows"]
        if row["dataset"] == "one"
    }
    assert rows["fake"]["ratio_to_other"] > 0
    assert rows["fake"]["ratio_to_other_low"] <= rows["fake"]["ratio_to_other_high"]
    assert rows["wrong"]["status"] == "failed"
    assert rows["wrong"]["wall_s"] > 0
    assert rows["wrong"]["ratio_to_other"] is None


def test_folder_of_another_run_is_not_overwritten(device, folder):
    with pytest.raises(ValueError, match="--resume"):
        open_folder(device, {}, out=folder)
    assert open_folder(device, {}, out=folder, resume=True) == folder
    assert len(read_run(folder).environment["resumed"]) == 1


def test_folder_of_another_device_or_commit_is_not_resumed(device, folder):
    environment = {**read_run(folder).environment, "slug": "abacus"}
    record.write_json(folder / record.RUN, environment)
    with pytest.raises(ValueError, match="resume: expected a run of device"):
        open_folder(device, {}, out=folder, resume=True)


def test_environment_says_where_and_with_what(folder):
    found = read_run(folder).environment
    assert found["device"]["name"]
    assert found["machine"]["cpu"]
    assert found["packages"]["numpy"]
    assert {"commit", "dirty", "started", "seed", "options", "variables", "pocl", "llvm"} <= set(
        found
    )


@pytest.mark.parametrize(("surface", "counted"), [(cup(), "patches_in"), (ball(), "surfaces_in")])
def test_patches_and_nurbs_are_seen_measured_and_compared(
    device, folder, monkeypatch, surface, counted
):
    takes = dataclasses.replace(
        fake.SYSTEMS["fake"],
        takes=(type(surface),),
        prepare=lambda device, surface, params: fake.Fake(device, finest(surface), params),
    )
    made = registry.Registry({**fake.SYSTEMS, "fake": takes})
    monkeypatch.setattr(registry, "registry", lambda: made)
    dataset = SimpleNamespace(name="one", surface=surface, standin=False, content="")
    monkeypatch.setattr(catalogue, "find", lambda name: dataset)
    group = Group("one", (Subject("fake"), Subject("other")), quality=True, zoom=2.0)
    measure(device, folder, group)
    (found,) = read_run(folder).groups
    quality = found.subjects["fake"].quality
    assert quality is not None and quality["rms_error"] < 1e-6
    assert found.subjects["other"].status == "skipped"
    assert "needs TriangleMesh" in found.subjects["other"].reason
    assert found.facts[counted] > 0


def test_another_seed_case_or_path_is_not_what_was_measured(device, folder):
    def measured(run_seed, **options):
        group = Group("one", (Subject("fake", **options.pop("subject", {})),), **options)
        session = Session(device, folder, samples=2, seed=run_seed)
        try:
            return record.config_hash(session._config("t", group))
        finally:
            session.close()

    path = CameraPath("orbit", 2)
    ways = [
        measured(0), measured(1), measured(0, subject={"case": "default"}), measured(0, seed=7),
        measured(0, path=path), measured(0, quality=True), measured(0, once=True),
    ]  # fmt: skip
    assert len(set(ways)) == len(ways)
    assert measured(0) == ways[0]
