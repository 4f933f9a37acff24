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
            subject("simplify_call", [1.5 * seconds] * 5),
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
    assert rows["simplify_call"]["frames_per_call"] == pytest.approx(1.5)
    assert rows["quadric_clustering"]["frames_per_call"] is None
    assert rows["quadric_clustering"]["published_ratio_to_cpu"] == 20
    assert rows["quadric_clustering"]["slope"] is None, "one size has no slope"
    rows, _ = rows_of("dt07_timing", scan, small, large)
    assert rows["quadric_clustering"]["slope"] == pytest.approx(1.0)
    assert rows["quadric_clustering"]["published_slope"] == 1


def judged(label, rms, largest, system="quadric_clustering", **more):
    quality = {"rms_error": rms, "max_error": largest, "open_edges": 3}
    return subject(label, [0.002] * 5, quality=quality, system=system, **more)


def test_borders_rows_have_errors_as_shares_of_those_without():
    held = judged("quadrics", 0.001, 0.01, counters={"border_edges": 12, "triangles": 90})
    made = group(judged("none", 0.002, 0.05), held, table="borders")
    rows, _ = rows_of("borders", made)
    assert rows["quadrics"]["rms_error_share"] == pytest.approx(0.5)
    assert rows["quadrics"]["max_error_share"] == pytest.approx(0.2)
    assert rows["quadrics"]["border_edges"] == 12


def test_grids_rows_have_the_error_as_a_share_of_averages():
    made = group(
        judged("quadric", 0.001, 0.01), judged("vertex_average", 0.004, 0.02, "vertex_average"),
        table="dt07_grids",
    )  # fmt: skip
    rows, _ = rows_of("dt07_grids", made)
    assert rows["quadric"]["rms_error_share"] == pytest.approx(0.25)
    assert rows["vertex_average"]["rms_error_share"] == 1


@pytest.mark.parametrize("name", ["borders", "dt07_grids"])
def test_quick_groups_are_fewer_and_valid(name):
    counts = []
    for quick in (True, False):
        groups = table(name).groups(quick)
        counts.append(len(groups))
        for found in groups:
            found.validate()
    assert counts[0] < counts[1]


def test_dt07_chain_rows_have_shares_of_the_first_level_and_what_a_level_costs_anew():
    first = {"pass_1_and_3": 0.9, "pass_2": 0.1}
    tail = {"level_2": 0.15, "level_3": 0.04, "level_4": 0.01}
    counters = {
        "triangles": 1000,
        **{f"level_{k}_triangles": 1000 >> 2 * (k - 1) for k in (2, 3, 4)},
    }
    quality = {"rms_error": 1e-3}
    chains = [
        subject(
            f"level_{k}", [first | dict(list(tail.items())[: k - 1])] * 5, system="level_chain",
            params={"cells": 40.0, "levels": k}, counters=counters, quality=quality,
        )
        for k in (1, 2, 3, 4)
    ]  # fmt: skip
    again = [
        subject(
            f"anew_{k}", [0.9] * 5, system="quadric_clustering", counters={"triangles": 1000 >> k},
            params={"cells": 40 / 2 ** (k - 1)}, quality=quality,
        )
        for k in (2, 3, 4)
    ]  # fmt: skip
    rows, _ = rows_of("dt07_chain", group(*chains, *again, table="dt07_chain", dataset="bunny"))
    assert [rows[f"level_{k}"]["share"] for k in (2, 3, 4)] == pytest.approx([0.15, 0.19, 0.2])
    assert rows["level_4"]["chain_ratio"] == pytest.approx(3.7 / 1.2)
    assert rows["level_3"]["level_ratio"] == pytest.approx(0.9 / 0.04)
    assert rows["level_3"]["level_s"] == pytest.approx(0.04)
    assert rows["level_3"]["triangles_out"] == 62
    assert rows["level_3"]["rms_error"] is None, "what was judged is the first level"
    assert rows["level_1"]["rms_error"] == rows["anew_3"]["rms_error"] == 1e-3
    assert rows["level_1"].get("share") is rows["anew_2"].get("share") is None
    assert rows["anew_2"]["level"] == 2


def test_dt07_chain_has_no_share_where_a_subject_failed():
    kept = [
        subject(f"level_{k}", [1.0] * 5, system="level_chain", counters={"triangles": 9})
        for k in (1, 2)
    ]
    failed = subject("anew_2", [], status="failed", system="quadric_clustering")
    rows, _ = rows_of("dt07_chain", group(*kept, failed, table="dt07_chain", dataset="bunny"))
    assert rows["level_2"].get("share") is None
    assert rows["anew_2"]["status"] == "failed"


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
