import pytest

from lodbench.harness.plan.table import table
from tests.harness.records import group, rows_of, subject

TABLES = ("rc13_2_1", "rc13_figures_2_10_to_2_13", "rc13_5_1_to_5_3", "rc13_5_13_to_5_18")


@pytest.mark.parametrize("name", TABLES)
def test_every_group_is_valid_and_quick_ones_are_fewer(name):
    quick, full = table(name).groups(True), table(name).groups(False)
    for found in full:
        found.validate()
    assert {g.name for g in quick} <= {g.name for g in full}
    assert 0 < len(quick) < len(full)


def test_triangles_of_scenes_are_in_thousands():
    counters = {"triangles": 81_920, "patches": 160}
    found = group(
        subject("level_4", [0.1], counters=counters, params={"level": 4}, system="vst"),
        table="rc13_2_1", scene="S5 teapot",
    )  # fmt: skip
    rows, _ = rows_of("rc13_2_1", found)
    assert (rows["level_4"]["triangles_k"], rows["level_4"]["patches"]) == (81.92, 160)


def test_rows_say_what_is_reused_and_how_fast_vertices_come():
    counters = {"triangles": 1000, "vertices": 4000, "zones": 8}
    found = group(
        subject("vst", [0.001] * 10, counters=counters),
        subject("gst", [0.002] * 10, counters=counters),
        subject("gst_no_reuse", [0.004] * 10, counters=counters, system="gst"),
        table="rc13_figures_2_10_to_2_13",
    )
    rows, _ = rows_of("rc13_figures_2_10_to_2_13", found)
    assert rows["vst"]["vertices_per_s"] == pytest.approx(4e6)
    assert rows["gst"]["reused"] == "zone and row" and rows["gst_no_reuse"]["reused"] == "none"
    assert rows["gst"]["ratio_to_gst_no_reuse"] == pytest.approx(2)
    assert rows["vst"]["published_frame_fps"] is None


def test_samples_of_drawn_groups_are_whole_frames():
    counters = {"triangles": 1000, "vertices": 600}
    found = group(
        subject("vst", [0.002] * 10, counters=counters),
        subject("gl_vst", [0.02] * 10, counters=counters, driver="a driver"),
        table="rc13_figures_2_10_to_2_13",
        scene="S1 teapot, drawn",
    )
    rows, _ = rows_of("rc13_figures_2_10_to_2_13", found)
    assert rows["vst"]["frame_fps"] == pytest.approx(500)
    assert rows["vst"]["vertices_per_s"] is None
    assert rows["vst"]["ratio_to_gl_vst"] == pytest.approx(10)
    assert rows["gl_vst"]["driver"] == "a driver"


def test_rate_over_the_flat_pattern_counts_vertices():
    found = group(
        subject("vst", [0.002] * 10, counters={"triangles": 1000, "vertices": 600}),
        subject("flat_patches", [0.001] * 10, counters={"triangles": 1000, "vertices": 660}),
        table="rc13_figures_2_10_to_2_13",
    )
    rows, _ = rows_of("rc13_figures_2_10_to_2_13", found)
    assert rows["vst"]["rate_to_flat_patches"] == pytest.approx(0.5 * 600 / 660)
    assert rows["flat_patches"]["rate_to_flat_patches"] is None


def test_a_draw_takes_its_share_of_the_frame():
    counters = {"triangles": 1000, "draws": 4}
    found = group(
        subject("uniform", [0.002] * 10, counters=counters, system="vsthd"),
        subject("texture", [0.004] * 10, counters=counters, system="vsthd"),
        table="rc13_5_13_to_5_18",
    )
    rows, _ = rows_of("rc13_5_13_to_5_18", found)
    assert rows["uniform"]["draw_s"] == pytest.approx(0.0005)
    assert rows["uniform"]["ratio_to_texture"] == pytest.approx(2)


def test_handheld_draws_have_their_sizes():
    counters = {"triangles": 20_480, "map_bytes": 6804, "draws": 23, "uniform_vectors": 116}
    params = {"level": 3, "surfaces_per_draw": 7}
    found = group(
        subject("level_3_by_7", [0.1], counters=counters, params=params, system="vsthd"),
        table="rc13_5_1_to_5_3",
    )
    row = rows_of("rc13_5_1_to_5_3", found)[0]["level_3_by_7"]
    assert (row["draws"], row["map_bytes"], row["surfaces_per_draw"]) == (23, 6804, 7)
