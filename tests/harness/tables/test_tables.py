import csv
import io
import json
from pathlib import Path

import pytest

from lodbench.harness import tables
from lodbench.harness.ratios import ratios
from lodbench.harness.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.tables import Column, Table, measured


def subject(label, seconds, *, status="ok", **facts):
    """Samples in turns 3, 4 ...; `seconds` is a list of wall times, or of {stage: seconds}."""
    found = SubjectRecord(label, system=label, status=status, reason="", **facts)
    for turn, value in enumerate(seconds, 3):
        stages = value if isinstance(value, dict) else {"call": value}
        wall = sum(stages.values())
        found.samples.append({"turn": turn, "wall_s": wall, "cpu_s": wall, "stage_s": stages})
    return found


def group(*subjects, table="t", config=None, others=0.0, **facts):
    found = GroupRecord(
        "g", table, "n", str(facts.get("dataset")), "d", facts, config or {}, others
    )
    found.subjects = {subject.label: subject for subject in subjects}
    return found


def run(*groups):
    return RunRecord(Path(), {"seed": 0, "device": {"name": "a device"}}, list(groups))


def rows_of(name, *groups):
    made = tables.document(tables.table(name), run(*groups))
    return {row["system"]: row for row in made["rows"]}, made


def test_share_of_the_limit_is_taken_against_medians_not_against_one_best_sample():
    one = subject("a", [{"vertex": 0.5}] * 10, traffic={"vertex": {"bytes": 10, "flops": 0}})

    def rate(best, median):
        return {"subject": "k", "unit": "B/s", "best": best, "median": median, "samples": [best]}

    found = run(group(one))
    names = ("copy", "multiply_add", "launch_wall", "launch_event")
    rest = {name: rate(9.0, 9.0) for name in names}
    found.limits = {"device": "d", "size_bytes": 1, "fill": rate(1000.0, 40.0), **rest}
    assert tables.limit_share(found, one) == pytest.approx(10 / 40 / 0.5)


def test_ratio_says_how_many_times_faster_the_row_is():
    both = group(subject("ours", [1.0, 2.0, 3.0]), subject("theirs", [4.0, 8.0, 12.0]))
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
            subject(name, [1.0] * 3, counters={} if count is None else {"triangles": count})
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


def test_single_sample_of_a_very_slow_subject_still_gives_a_ratio_without_interval():
    slow = subject("theirs", [40.0])
    slow.samples[0]["turn"] = 0
    both = group(subject("ours", [2.0] * 10), slow)
    row = ratios(both, both.subjects["ours"], ["theirs"])
    assert (row["ratio_to_theirs"], row["ratio_to_theirs_low"]) == (20, None)


def test_noisy_row_says_why():
    row = measured(group(others=0.5), subject("ours", [1.0] * 10))
    quiet = measured(group(others=0.5), subject("ours", [1.0] * 10))
    assert row == quiet
    found = group(subject("ours", [1.0] * 10), others=0.5)
    row = measured(found, found.subjects["ours"])
    assert (row["status"], row["samples"]) == ("noisy", 10)
    assert "50%" in row["reason"]


def test_written_table_is_the_same_in_json_csv_and_markdown(tmp_path):
    made = Table(
        "x", "A title", "A source", lambda quick: [],
        (Column("system", "system"), Column("wall_s", "median wall", "s"), Column("none", "empty")),
        lambda run, records: [{"system": "a|b", "wall_s": 0.00123456, "other": 3, "status": "ok"}],
        ("a note",),
    )  # fmt: skip
    record = run()
    record.folder = tmp_path
    tables.write(made, record)
    written = json.loads((tmp_path / "tables/x.json").read_text())
    assert {"id", "title", "source", "device", "columns", "rows"} <= set(written)
    assert written["columns"][1] == {"key": "wall_s", "label": "median wall", "unit": "s"}
    assert written["rows"] == [
        {"system": "a|b", "wall_s": 0.00123456, "none": None, "status": "ok", "reason": None}
    ]
    text = (tmp_path / "tables/x.md").read_text()
    assert r"| a\|b | 1.235 ms |" in text
    assert "empty" not in text
    assert "- a note" in text
    (row,) = csv.DictReader(io.StringIO((tmp_path / "tables/x.csv").read_text()))
    assert (row["wall_s"], row["none"]) == ("0.00123456", "")


def test_every_table_names_its_module_and_has_status_columns_and_unique_keys():
    for name, table in tables.tables().items():
        assert __import__(f"lodbench.harness.tables.{name}", fromlist=["x"]).TABLE is table
        keys = [column["key"] for column in tables.document(table, run())["columns"]]
        assert len(keys) == len(set(keys))
        assert {"system", "wall_s", "status", "reason"} <= set(keys)


def test_every_table_has_different_groups_with_different_labels():
    for table in tables.tables().values():
        for quick in (False, True):
            names = [made.name for made in table.groups(quick)]
            assert len(set(names)) == len(names)
            for made in table.groups(quick):
                labels = [subject.name for subject in made.subjects]
                assert len(set(labels)) == len(labels)


def test_gmr05_rows_have_both_counts_and_published_values():
    counters = {"vertices": 10 * 2145}
    static = {"stored_vertices": 21_450, "static_vertices": 21_450, "batches": 1}
    small = {"stored_vertices": 2145, "static_vertices": 21_450, "batches": 1}
    rows, made = rows_of(
        "gmr05_figure7",
        group(
            subject("static_vbo", [0.002] * 10, counters=counters, footprint=static),
            subject("pattern_per_triangle", [0.004] * 10, counters=counters, footprint=small),
            subject("device_fill", [0.001] * 10),
            table="gmr05_figure7", segments=64, coarse_triangles=10, dataset="sphere_10",
        ),
    )  # fmt: skip
    assert rows["static_vbo"]["published_frame_fps"] == 973.10
    assert rows["static_vbo"]["stored_vertices_square"] == 42_250
    assert rows["static_vbo"]["published_vertices"] == 42_250
    ours = rows["pattern_per_triangle"]
    assert ours["stored_vertices"] == 2145
    assert ours["stored_vertices_square"] == ours["published_vertices"] == 4225
    assert ours["stored_share"] == 0.1  # one pattern for ten coarse triangles
    assert ours["stage_fps"] == pytest.approx(250)
    assert ours["frame_fps"] is None
    assert ours["fill_share"] == pytest.approx(0.25)
    assert ours["ratio_to_static_vbo"] == pytest.approx(0.5)
    assert ours["published_ratio_to_static_vbo"] == pytest.approx(965.12 / 973.10)
    assert ours["vertices_per_s"] == pytest.approx(10 * 2145 / 0.004)
    assert any("331,938" in note for note in made["notes"])


def test_dt07_rows_have_passes_ratios_and_the_exponent_of_time():
    def sized(name, triangles, seconds):
        passes = {"pass_1": 0.7 * seconds, "pass_2": 0.1 * seconds, "pass_3": 0.2 * seconds}
        return group(
            subject("quadric_clustering", [seconds] * 5, params={"cells": 40.5}),
            subject("separate", [passes] * 5),
            subject("fast_simplification", [20 * seconds] * 5),
            table="dt07_timing", config={"dataset": name}, dataset=name, triangles_in=triangles,
        )  # fmt: skip

    small = sized("displaced_icosphere_100k", 100_000, 0.001)
    large = sized("displaced_icosphere_10m", 10_000_000, 0.1)
    scan = sized("bunny_69k", 70_000, 0.001)
    rows, _ = rows_of("dt07_timing", small)
    assert rows["separate"]["pass_1_share"] == pytest.approx(0.7)
    assert rows["separate"]["published_pass_1_share"] == 0.75
    assert rows["quadric_clustering"]["pass_1_s"] is None
    assert rows["quadric_clustering"]["ratio_to_fast_simplification"] == pytest.approx(20)
    assert rows["quadric_clustering"]["cells"] == 40.5
    assert rows["quadric_clustering"]["published_ratio_to_cpu"] == 20
    assert rows["quadric_clustering"]["time_exponent"] is None, "one size has no slope"
    rows, _ = rows_of("dt07_timing", scan, small, large)
    assert rows["quadric_clustering"]["time_exponent"] == pytest.approx(1.0)
    assert rows["quadric_clustering"]["published_time_exponent"] == 1


def test_gmr05_frames_stand_apart_from_samples_and_beside_the_published_ones():
    static, ours = subject("static_vbo", [0.001] * 4), subject("pattern_per_triangle", [0.002] * 4)
    for found, seconds in ((static, 0.02), (ours, 0.01)):
        found.frames = [{"turn": turn, "wall_s": seconds} for turn in range(3, 7)]
    rows, _ = rows_of(
        "gmr05_figure7",
        group(static, ours, table="gmr05_figure7", segments=64, coarse_triangles=10),
    )
    row = rows["pattern_per_triangle"]
    assert row["stage_fps"] == pytest.approx(500)
    assert (row["frame_fps"], row["frames"]) == (pytest.approx(100), 4)
    assert row["frame_ratio_to_static_vbo"] == pytest.approx(2)
    assert row["ratio_to_static_vbo"] == pytest.approx(0.5)
    assert row["published_frame_fps"] == 965.12
    assert rows["static_vbo"]["frame_ratio_to_static_vbo"] is None


def test_real_shader_rows_name_the_driver_and_flag_a_single_sample():
    theirs = subject("gl_tessellation", [40.0], driver="a driver")
    found = group(
        subject("pattern", [0.01] * 10), theirs, table="real_shaders", work="refine and draw"
    )
    rows, _ = rows_of("real_shaders", found)
    assert rows["gl_tessellation"]["driver"] == "a driver"
    assert rows["gl_tessellation"]["reason"] == "one sample: over 30 s"
    assert rows["pattern"]["ratio_to_gl_tessellation"] == pytest.approx(4000)
    assert rows["pattern"]["frame_fps"] == pytest.approx(100)
    found.facts["work"] = "refine"
    assert rows_of("real_shaders", found)[0]["pattern"]["frame_fps"] is None


def test_real_shaders_quick_run_leaves_out_what_takes_a_software_driver_minutes():
    table = tables.table("real_shaders")
    assert max(made.facts.get("segments", 0) for made in table.groups(True)) == 16
    assert max(made.facts.get("segments", 0) for made in table.groups(False)) == 64


def test_quick_run_measures_every_table_on_smaller_inputs():
    for table in tables.tables().values():
        sizes = []
        for quick in (True, False):
            entries = [group.found().triangles or 0 for group in table.groups(quick)]
            assert entries, table.id
            sizes.append(max(entries))
        assert sizes[0] <= min(sizes[1], 1_100_000), table.id
