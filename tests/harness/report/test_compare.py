"""What `lodbench compare` calls worse, beyond time."""

import pytest

from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.report.compare import compare

QUALITY = {
    "rms_error": 1e-4, "rms_error_back": 1e-4, "max_error": 1e-3,
    "open_edges": 0, "nonmanifold_edges": 7, "flipped_triangles": 2,
}  # fmt: skip


def subject(name="a", status="ok", triangles=100, wall=1.0, **quality):
    found = SubjectRecord(name, name, status, "why not" if status != "ok" else "")
    found.counters, found.quality = {"triangles": triangles}, QUALITY | quality
    found.samples = [{"turn": t, "wall_s": wall * (1 + 0.001 * (t % 3))} for t in range(10)]
    return found


def run(tmp_path, *subjects, group="g"):
    record = GroupRecord("h", "t", group, "d", "dev", {}, {})
    record.subjects = {one.label: one for one in subjects}
    environment = {"device": {"name": "x"}, "machine": {"cpu": "y"}}
    return RunRecord(tmp_path, environment, [record])


@pytest.mark.parametrize(
    ("changed", "why"),
    [
        ({"rms_error": 1.02e-4}, "rms_error 0.0001 -> 0.000102"),
        ({"rms_error_back": 2e-4}, "rms_error_back 0.0001 -> 0.0002"),
        ({"max_error": 1.1e-3}, "max_error 0.001 -> 0.0011"),
        ({"open_edges": 1}, "open_edges 0 -> 1"),
        ({"nonmanifold_edges": 8}, "nonmanifold_edges 7 -> 8"),
        ({"flipped_triangles": 3}, "flipped_triangles 2 -> 3"),
        ({"triangles": 99}, "triangles 100 -> 99"),
        ({"status": "failed"}, "failed: why not"),
        ({"status": "skipped"}, "skipped: why not"),
        ({"wall": 2.0}, "slower"),
        ({"wall": 2.0, "open_edges": 4}, "open_edges 0 -> 4; slower"),
    ],
)
def test_compare_names_what_is_worse(tmp_path, changed, why):
    found = compare(run(tmp_path, subject()), run(tmp_path, subject(**changed)))
    (row,) = found["rows"]
    assert (row["verdict"], row["why"], found["regressions"]) == ("regression", why, 1)


@pytest.mark.parametrize(
    "changed",
    [{}, {"rms_error": 1.005e-4}, {"max_error": 1.04e-3}, {"rms_error": 5e-5}, {"open_edges": 0}],
)
def test_compare_lets_the_same_and_the_better_pass(tmp_path, changed):
    found = compare(run(tmp_path, subject()), run(tmp_path, subject(**changed)))
    assert found["rows"][0]["verdict"] == "same"
    assert found["regressions"] == 0


@pytest.mark.parametrize(
    ("walls", "verdict"),
    [
        ([1.0, 1.0, 1.05, 1.4, 1.4], "same"),
        ([0.6, 0.6, 0.95, 1.0, 1.0], "same"),
        ([1.2, 1.2, 1.3, 1.4, 1.4], "regression"),
        ([0.6, 0.6, 0.7, 0.8, 0.8], "faster"),
    ],
)
def test_time_is_worse_or_better_where_the_whole_interval_is(tmp_path, walls, verdict):
    old, new = subject(), subject()
    new.samples = [{"turn": turn, "wall_s": wall} for turn, wall in enumerate(2 * walls)]
    (row,) = compare(run(tmp_path, old), run(tmp_path, new))["rows"]
    assert row["verdict"] == verdict
    if verdict == "same":
        assert row["ratio_low"] < 1.1 and row["ratio_high"] > 0.9
        assert row["ratio_low"] < 0.9 or row["ratio_high"] > 1.1


def test_compare_names_rows_of_one_run_alone(tmp_path):
    a, b = subject("a"), subject("b")
    found = compare(run(tmp_path, a, b), run(tmp_path, a, subject("c")))
    assert [(row["system"], row["verdict"]) for row in found["rows"]] == [
        ("a", "same"), ("b", "missing"), ("c", "new"),
    ]  # fmt: skip
    assert found["regressions"] == 2


def test_compare_refuses_runs_with_nothing_in_common(tmp_path):
    with pytest.raises(ValueError, match="B: expected a run that has rows of"):
        compare(run(tmp_path, subject()), run(tmp_path, subject(), group="other"))
