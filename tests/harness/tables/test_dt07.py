import pytest

from lodbench.harness.plan.table import table
from tests.harness.records import group, rows_of, subject


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
    assert rows["quadric_clustering"]["slope"] is None, "one size has no slope"
    rows, _ = rows_of("dt07_timing", scan, small, large)
    assert rows["quadric_clustering"]["slope"] == pytest.approx(1.0)
    assert rows["quadric_clustering"]["published_slope"] == 1


def test_warped_rows_say_how_much_closer_they_are_than_the_even_grid():
    def found(label, **quality):
        return subject(label, [0.001] * 4, counters={"triangles": 100}, quality=quality)

    even = found("even", rms_error_inside=0.004, triangles_inside=10)
    fine = found("region_4", rms_error_inside=0.001, triangles_inside=40)
    rows, _ = rows_of("dt07_warps", group(even, fine, table="dt07_warps", warp="region"))
    assert (rows["even"]["closer"], rows["region_4"]["closer"]) == (1, 4)
    assert rows["region_4"]["triangles_inside"] == 40
    assert rows["region_4"]["rms_pixels"] is None
    even = found("even", rms_error_inside=0.001, rms_pixels=6.0)
    seen = found("view_log", rms_error_inside=0.002, rms_pixels=3.0)
    rows, _ = rows_of("dt07_warps", group(even, seen, table="dt07_warps", warp="view"))
    assert rows["view_log"]["closer"] == 2


def test_every_group_of_warps_has_its_focus_and_quick_ones_are_one_of_each():
    groups = table("dt07_warps").groups(False)
    for one in groups:
        one.validate()
    assert all(one.focus is not None and one.quality for one in groups)
    quick = table("dt07_warps").groups(True)
    assert [one.facts["warp"] for one in quick] == ["region", "view"]
    configs = {str(one.config()) for one in groups}
    assert len(configs) == len(groups)
