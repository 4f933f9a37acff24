import pytest

from lodbench.harness.plan.table import table
from tests.harness.records import group, rows_of, subject

TABLES = (
    "rc13_2_1", "rc13_figures_2_10_to_2_13", "rc13_3_1", "rc13_3_18_3_19", "rc13_4_1_4_2",
    "rc13_4_6_to_4_8", "rc13_exactness", "rc13_5_1_to_5_3", "rc13_5_13_to_5_18",
)  # fmt: skip


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


def _compared(label, triangles, error, **params):
    quality = {"mean_difference": error, "rms_difference": 2 * error, "max_difference": 9 * error}
    system = label.rpartition("_")[0] or label
    return subject(
        label,
        [0.1],
        counters={"triangles": triangles},
        params=params,
        system=system,
        quality=quality,
    )


def test_shares_are_of_uniform_triangles_at_equal_mean_error():
    found = group(
        _compared("vst_1", 1000, 4e-3), _compared("vst_2", 4000, 1e-3), _compared("vst_3", 16_000, 25e-5),
        _compared("dabt_high", 1000, 2e-3, test="distance", quality="high"),
        _compared("dabt_low", 500, 4e-3, test="flat", quality="low", threshold=0.5),
        _compared("uncoupled_bezier_1", 400, 1e-3, price=1e-7),
        subject("reference", [0.1], counters={"triangles": 10**6}, system="vst"),
        table="rc13_3_1", dataset="elephant_gumbo",
    )  # fmt: skip
    rows, _ = rows_of("rc13_3_1", found)
    assert rows["dabt_high"]["share_at_error"] == pytest.approx(0.5)
    assert rows["dabt_high"]["share_of_level"] == pytest.approx(0.25)
    assert rows["dabt_low"]["threshold"] == 0.5
    assert rows["dabt_low"]["share_at_error"] == pytest.approx(0.5)
    assert rows["dabt_low"]["share_of_level"] == 0.5
    assert rows["uncoupled_bezier_1"]["share_at_error"] == pytest.approx(0.1)
    assert rows["vst_1"].get("share_at_error") is None
    published = rows["dabt, length, high quality, a model not named"]
    assert (published["published_triangles_k"], published["published_frame_fps"]) == (
        284.94,
        148.97,
    )


def test_adaptive_frames_are_compared_whatever_triangles_they_have():
    found = group(
        subject("vst", [0.002] * 10, counters={"triangles": 4000}),
        subject("semi_adaptive", [0.001] * 10, counters={"triangles": 2000}),
        subject("dabt", [0.002] * 10, counters={"triangles": 1800}),
        table="rc13_4_6_to_4_8", work="frames",
    )  # fmt: skip
    rows, _ = rows_of("rc13_4_6_to_4_8", found)
    assert rows["semi_adaptive"]["ratio_to_dabt"] == pytest.approx(2)
    assert rows["dabt"]["ratio_to_vst"] == pytest.approx(1)
    assert rows["vst"]["triangles_k"] == 4
    counted = group(
        subject("dabt", [0.1], counters={"triangles": 5000, "coarse_triangles": 100}),
        table="rc13_4_1_4_2", scene="S5 teapot", level=5,
    )  # fmt: skip
    row = rows_of("rc13_4_1_4_2", counted)[0]["dabt"]
    assert (row["adapts"], row["triangles_k"]) == ("edges and inside", 5)


def test_figures_of_a_tessellation_stand_in_one_row():
    def told(**values):
        return {
            name: {"value": value, "limit": 1, "looked_at": f"of {name}"}
            for name, value in values.items()
        }

    found = group(
        subject("vst", [], exact=told(points=1e-7, normals=0.02, cracks=0, vertices=0)),
        subject("gl_vst", [], exact=told(points=2e-7, normals=0.01, open=32)),
        subject("vsthd", [], status="failed"),
        table="rc13_exactness",
    )
    rows, _ = rows_of("rc13_exactness", found)
    assert rows["vst"]["exact_points"] == 1e-7 and rows["vst"]["looked_at"] == "of points"
    assert (rows["vst"]["exact_cracks"], rows["vst"]["exact_bytes"]) == (0, None)
    assert rows["gl_vst"]["exact_cracks"] == 32
    assert rows["vsthd"]["exact_points"] is None
