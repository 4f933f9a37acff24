"""Simplifiers of every kind, asked for the same, are compared; asked for different things, they are not."""

import json

import pytest

from lodbench.harness.cli.app import main
from lodbench.harness.report.ratios import ratios
from lodbench.harness.report.rows import measured
from tests.harness.records import group, subject

SYSTEMS = ["quadric_clustering", "fast_simplification", "numpy_quadric_clustering", "simplify_call"]


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    """Rows of a sweep over the target, by target and system."""
    folder = tmp_path_factory.mktemp("sweep")
    (folder / "targets.toml").write_text(
        f"systems = {SYSTEMS}\ndatasets = ['displaced_icosphere_20k']\n"
        "[params]\ntarget_reduction = [0.8, 0.97]\n"
    )
    words = ["sweep", str(folder / "targets.toml"), "--samples", "1", "-q"]
    assert main([*words, "--out", str(folder / "run")]) == 0
    made = json.loads((folder / "run/tables/targets.json").read_text())
    return {(row["target_reduction"], row["system"]): row for row in made["rows"]}


@pytest.mark.parametrize("share", [0.8, 0.97])
def test_sweep_over_a_target_compares_like_with_like(rows, share):
    asked = round((1 - share) * 20480)
    for system in SYSTEMS:
        row = rows[share, system]
        assert row["status"] in ("ok", "noisy")
        assert 0.95 * asked <= row["triangles_out"] <= asked
        if system != SYSTEMS[0]:
            assert row["ratio_to_quadric_clustering"] > 0
        assert "no ratio" not in row["reason"]


def test_run_with_unlike_counts_has_no_ratio_and_says_so(capsys, tmp_path):
    words = ["run", "quadric_clustering", "-d", "icosphere_4", "-a", "fast_simplification"]
    out = ["--samples", "1", "-q", "--out", str(tmp_path / "run")]
    assert main([*words, "-s", "cells=20", *out]) == 0
    assert "no ratio: to quadric_clustering: 512 triangles against" in capsys.readouterr().out
    (table,) = (tmp_path / "run/tables").glob("*.json")
    ours, theirs = json.loads(table.read_text())["rows"]
    assert ours["triangles_out"] > 2 * theirs["triangles_out"]
    assert theirs["ratio_to_quadric_clustering"] is None
    assert theirs["reason"].endswith(f"512 triangles against {ours['triangles_out']:,}")


def test_cells_of_a_case_give_way_to_a_target(capsys, tmp_path):
    words = ["run", "quadric_clustering", "-d", "icosphere_4", "--case", "cells_30", "--json"]
    out = ["--samples", "1", "-q", "--out", str(tmp_path / "run")]
    assert main([*words, "-s", "target_count=400", *out]) == 0
    (row,) = json.loads(capsys.readouterr().out)[0]["rows"]
    assert 380 <= row["triangles_out"] <= 400


def test_ratio_says_how_many_times_faster_the_row_is():
    both = group(subject("ours", 2 * [1.0, 2.0, 3.0]), subject("theirs", 2 * [4.0, 8.0, 12.0]))
    row = ratios(both, both.subjects["ours"], ["theirs"])
    assert row == {"ratio_to_theirs": 4, "ratio_to_theirs_low": 4, "ratio_to_theirs_high": 4}
    assert ratios(both, both.subjects["theirs"], ["theirs", "absent"]) == dict.fromkeys(
        f"ratio_to_{name}{end}" for name in ("theirs", "absent") for end in ("", "_low", "_high")
    )


@pytest.mark.parametrize("bad", [{"status": "failed"}, {"footprint": {"batches": 3}}])
def test_failed_and_batched_rows_stay_out_of_ratios(bad):
    both = group(subject("ours", [1.0] * 3), subject("theirs", [4.0] * 3, **bad))
    assert ratios(both, both.subjects["ours"], ["theirs"])["ratio_to_theirs"] is None
    assert ratios(both, both.subjects["theirs"], ["ours"])["ratio_to_ours"] is None


def test_unlike_counts_give_no_ratio_and_say_so():
    kinds = {"ours": 12_314, "theirs": 128, "same": 12_000, "fill": None}
    both = group(
        *(
            subject(name, [1.0] * 6, counters={} if count is None else {"triangles": count})
            for name, count in kinds.items()
        )
    )
    ours = both.subjects["ours"]
    row = measured(both, ours) | ratios(both, ours, ["theirs", "same", "fill"])
    assert row["ratio_to_theirs"] is row["ratio_to_theirs_low"] is None
    assert row["ratio_to_same"] == row["ratio_to_fill"] == 1
    assert (row["status"], row["reason"]) == (
        "ok", "no ratio to theirs: 12,314 triangles against 128",
    )  # fmt: skip
    back = ratios(both, both.subjects["theirs"], ["ours", "same"])
    assert back["reason"] == (
        "no ratio to ours: 128 triangles against 12,314; "
        "no ratio to same: 128 triangles against 12,000"
    )
    meant = ratios(both, ours, ["theirs"], any_count=["theirs"])
    assert meant["ratio_to_theirs"] == 1
    assert "reason" not in meant
    assert (
        ratios(both, both.subjects["theirs"], ["ours"], any_count=["theirs"])["ratio_to_ours"] == 1
    )


@pytest.mark.parametrize(("count", "given"), [(95, True), (94, False), (105, True), (106, False)])
def test_like_counts_are_within_five_per_cent(count, given):
    both = group(
        subject("ours", [1.0] * 3, counters={"triangles": 100}),
        subject("theirs", [1.0] * 3, counters={"triangles": count}),
    )
    row = ratios(both, both.subjects["ours"], ["theirs"])
    assert (row["ratio_to_theirs"] is not None) == given


def test_reason_for_unlike_counts_joins_that_of_the_noise():
    both = group(
        subject("ours", [1.0] * 10, counters={"triangles": 100}),
        subject("theirs", [1.0] * 10, counters={"triangles": 200}),
        others=0.5,
    )
    row = measured(both, both.subjects["ours"]) | ratios(both, both.subjects["ours"], ["theirs"])
    assert row["status"] == "noisy"
    assert "50%" in row["reason"] and row["reason"].endswith("100 triangles against 200")


def test_too_few_samples_for_an_interval_are_said():
    both = group(
        subject("ours", [1.0] * 10), subject("theirs", [4.0] * 3), subject("other", [1.0] * 9)
    )
    row = ratios(both, both.subjects["ours"], ["theirs", "other"])
    assert (row["ratio_to_theirs"], row["ratio_to_theirs_low"]) == (4, None)
    assert row["ratio_to_other_low"] == 1
    assert row["reason"] == "too few samples for an interval of the ratio to theirs: 3 of 6"


def test_single_sample_of_a_very_slow_subject_still_gives_a_ratio_without_interval():
    slow = subject("theirs", [40.0])
    slow.samples[0]["turn"] = 0
    both = group(subject("ours", [2.0] * 10), slow)
    row = ratios(both, both.subjects["ours"], ["theirs"])
    assert (row["ratio_to_theirs"], row["ratio_to_theirs_low"]) == (20, None)
