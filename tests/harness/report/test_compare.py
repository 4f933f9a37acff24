"""What `lodbench compare` calls worse, beyond time."""

import re
from dataclasses import replace

import numpy as np
import pytest

from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.report.compare import LEVEL, compare, confirm

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


def verdicts(found):
    return [(row["system"], row["verdict"]) for row in found["rows"]]


@pytest.mark.parametrize(
    ("wall", "threshold", "verdict"),
    [
        (1.08, 0.10, "same"),
        (1.08, 0.05, "regression"),
        (1.2, 0.10, "regression"),
        (0.93, 0.10, "same"),
        (0.93, 0.05, "faster"),
        (0.5, 0.10, "faster"),
    ],
)
def test_time_counts_where_its_whole_interval_lies_beyond_the_threshold(
    tmp_path, wall, threshold, verdict
):
    found = compare(run(tmp_path, subject()), run(tmp_path, subject(wall=wall)), threshold)
    (row,) = found["rows"]
    assert (row["verdict"], found["threshold"]) == (verdict, threshold)
    assert row["ratio"] == pytest.approx(wall, rel=1e-3)
    assert row["ratio_low"] <= row["ratio"] <= row["ratio_high"]
    assert row["wall_s_b"] / row["wall_s_a"] == pytest.approx(row["ratio"], rel=1e-3)
    assert found["regressions"] == (verdict == "regression")


@pytest.mark.parametrize(
    ("changed", "verdict"), [({}, "too few"), ({"triangles": 9}, "regression")]
)
def test_two_samples_say_nothing_of_time_but_all_of_what_came_out(tmp_path, changed, verdict):
    short = subject(wall=3.0, **changed)
    short.samples = short.samples[:2]
    found = compare(run(tmp_path, subject()), run(tmp_path, short))
    (row,) = found["rows"]
    assert (row["verdict"], row["ratio_low"]) == (verdict, None)
    assert "slower" not in row["why"]


@pytest.mark.parametrize("status", ["failed", "skipped"])
def test_row_that_was_not_measured_before_is_no_regression(tmp_path, status):
    found = compare(run(tmp_path, subject(status=status)), run(tmp_path, subject(triangles=7)))
    (row,) = found["rows"]
    assert (row["verdict"], row["why"]) == ("not measured", f"A: {status}")
    assert (found["regressions"], row["ratio"]) == (0, None)


def test_error_that_one_side_lacks_is_not_compared(tmp_path):
    bare = subject()
    bare.quality, bare.counters = None, {}
    for a, b in ((subject(), bare), (bare, subject())):
        found = compare(run(tmp_path, a), run(tmp_path, b))
        assert verdicts(found) == [("a", "same")]
    assert found["rows"][0]["rms_error_a"] is None and found["rows"][0]["triangles_a"] is None


def test_pattern_keeps_rows_by_table_group_and_system(tmp_path):
    runs = [run(tmp_path, subject("a"), subject("b")) for _ in range(2)]
    for pattern, kept in (("b$", ["b"]), ("^t g", ["a", "b"]), ("g a", ["a"])):
        found = compare(*runs, keep=re.compile(pattern))
        assert [row["system"] for row in found["rows"]] == kept
    with pytest.raises(ValueError, match="B: expected a run that has rows of"):
        compare(*runs, keep=re.compile("nothing"))


def test_file_of_another_content_is_another_row(tmp_path):
    runs = [run(tmp_path, subject()) for _ in range(2)]
    for made, content in zip(runs, ("abc", "abc"), strict=True):
        made.groups[0].facts["content"] = content
    assert verdicts(compare(*runs)) == [("a", "same")]
    runs[1].groups[0].facts["content"] = "xyz"
    with pytest.raises(ValueError, match="expected a run that has rows"):
        compare(*runs)


def test_runs_of_two_machines_are_told_apart(tmp_path):
    a, b = run(tmp_path, subject()), run(tmp_path, subject())
    assert compare(a, b)["same_machine"]
    for key, inner in (("device", "name"), ("machine", "cpu")):
        other = run(tmp_path, subject())
        other.environment[key][inner] = "other"
        assert not compare(a, other)["same_machine"]


KERNELS = [f"kernel_{i}" for i in range(24)]


def measured(tmp_path, seed, slower=(), worse=()):
    """A run of 24 subjects, 40 samples each with a tail of slow ones; half a per cent is the run's, not theirs."""
    rng = np.random.default_rng(seed)
    subjects = []
    for name in KERNELS:
        one = subject(name, **({"rms_error": 1.1e-4} if name in worse else {}))
        wall = 1e-3 * rng.normal(1, 0.005) * (1.1 if name in slower else 1.0)
        noise = rng.lognormal(sigma=0.03, size=40) + 0.3 * rng.exponential(size=40) * (
            rng.random(40) < 0.1
        )
        one.samples = [{"turn": t, "wall_s": wall * s} for t, s in enumerate(noise)]
        subjects.append(one)
    return run(tmp_path, *subjects)


def test_twenty_comparisons_of_the_same_code_give_one_false_alarm_at_the_most(tmp_path):
    alarms = [
        compare(measured(tmp_path, 2 * seed), measured(tmp_path, 2 * seed + 1))["regressions"]
        for seed in range(20)
    ]
    assert sum(count > 0 for count in alarms) <= LEVEL * 20
    itself = measured(tmp_path, 0)
    assert {row["verdict"] for row in compare(itself, itself)["rows"]} == {"same"}


def test_slowdown_of_ten_per_cent_in_one_kernel_is_found_and_no_other(tmp_path):
    for seed in range(5):
        found = compare(
            measured(tmp_path, seed), measured(tmp_path, 100 + seed, slower=["kernel_17"])
        )
        named = [
            (row["system"], row["why"]) for row in found["rows"] if row["verdict"] == "regression"
        ]
        assert named == [("kernel_17", "slower")]


def test_error_larger_by_ten_per_cent_is_found_and_no_other(tmp_path):
    found = compare(measured(tmp_path, 1), measured(tmp_path, 2, worse=["kernel_5"]))
    (row,) = (row for row in found["rows"] if row["verdict"] == "regression")
    assert (row["system"], row["why"]) == ("kernel_5", "rms_error 0.0001 -> 0.00011")


@pytest.mark.parametrize("side", [0, 1])
def test_time_of_a_disturbed_run_is_not_judged_but_results_are(tmp_path, side):
    pair = [run(tmp_path, subject(wall=wall), subject("b", wall=wall)) for wall in (1.0, 1.5)]
    pair[side].groups[0].others = 0.3
    pair[1].groups[0].subjects["b"].counters = {"triangles": 99}
    found = compare(*pair)
    said = [(row["verdict"], row["why"]) for row in found["rows"]]
    assert said == [("busy", ""), ("regression", "triangles 100 -> 99")]
    assert (found["busy"], found["regressions"]) == (1, 1)


def test_slower_is_what_is_slower_in_every_further_run_too(tmp_path):
    a, slow, usual = (run(tmp_path, subject(wall=wall), subject("b")) for wall in (1.0, 1.5, 1.0))
    for again, verdict in (
        ((), "regression"),
        ((slow,), "regression"),
        ((slow, usual), "unconfirmed"),
    ):
        found = compare(a, slow)
        confirm(found, [compare(a, one) for one in again])
        assert [row["verdict"] for row in found["rows"]] == [verdict, "same"]
        assert found["regressions"] == (verdict == "regression")


def test_so_many_rows_that_no_result_could_be_sure_are_too_few_samples(tmp_path):
    # 1 / comb(12, 6) is 0.11 %: sure enough among 46 rows at 5 %, not among 48
    few = [measured(tmp_path, seed) for seed in (1, 2)]
    for made in few:
        for one in [*made.groups[0].subjects.values()]:
            del one.samples[6:]
            made.groups[0].subjects[f"{one.label}_b"] = replace(one, label=f"{one.label}_b")
    assert compare(*few)["too_few"] == 48
    assert compare(*few, keep=re.compile("_b"))["too_few"] == 0
