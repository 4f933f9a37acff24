import pytest

from lodbench.harness.plan.table import table
from lodbench.harness.tables.gems3_adaptive import at_equal_error
from tests.harness.records import group, rows_of, subject


def refined(label, triangles, error, system="pn_triangles"):
    quality = {"max_difference": error, "rms_difference": error / 4, "compared_points": 9}
    counters = {"triangles": triangles, "vertices": triangles // 2}
    return subject(label, [0.002] * 10, counters=counters, quality=quality, system=system)


def errors(*more):
    levels = [refined(f"pn_triangles_{2 << k}", 4000 * 4**k, 0.004 / 4**k) for k in range(3)]
    return group(*levels, *more, table="gems3_adaptive", work="error")


def test_uniform_triangles_at_equal_error_are_between_the_levels_and_those_of_the_next():
    found = errors()
    assert at_equal_error(found, 0.001) == (pytest.approx(16_000), 16_000)
    assert at_equal_error(found, 0.002) == (pytest.approx(8_000), 16_000)
    assert at_equal_error(found, 0.01) == (None, 4_000)
    assert at_equal_error(found, 1e-5) == (None, None)


def test_adaptive_rows_have_their_share_of_uniform_refinement():
    rows, _ = rows_of(
        "gems3_adaptive", errors(refined("curvature_1", 4000, 0.002, "adaptive_patterns"))
    )
    assert rows["curvature_1"]["share_at_error"] == pytest.approx(0.5)
    assert rows["curvature_1"]["share_of_level"] == pytest.approx(0.25)
    assert rows["pn_triangles_2"]["share_at_error"] is None
    assert rows["pn_triangles_2"]["vertices_per_s"] == pytest.approx(1e6)


def test_adaptive_rows_of_a_path_say_what_choosing_took_of_the_frame_and_how_far_it_moved():
    stages = {"tags": 2e-4, "selection": 3e-4, "vertex": 15e-4}
    counters = {"triangles": 10}
    drawn = subject("screen", [stages] * 4, counters=counters, system="adaptive_patterns")
    drawn.frames = [
        {"turn": k, "step": k, "wall_s": 0.01, "triangles": 10, "moved": 0.1 * k} for k in range(4)
    ]
    rows, _ = rows_of("gems3_adaptive", group(drawn, table="gems3_adaptive", work="path"))
    assert rows["screen"]["choosing_share"] == pytest.approx(0.05)
    assert rows["screen"]["most_moved"] == pytest.approx(0.3)


def test_pool_rows_are_what_the_subject_counted():
    counters = {
        "segments": 8, "patterns": 64, "lattice_vertices": 45, "pool_triangles": 2260,
        "pool_index_bytes": 27_120, "pool_bytes": 40_000, "triangles": 6400,
    }  # fmt: skip
    rows, _ = rows_of(
        "gems3_pool", group(subject("depth_3", [0.002] * 4, counters=counters), table="gems3_pool")
    )
    row = rows["depth_3"]
    assert (row["depth"], row["patterns"], row["unique_patterns"]) == (3, 64, 20)
    assert (row["pool_triangles"], row["pool_index_bytes"]) == (2260, 27_120)


def test_every_group_has_its_reference_and_quick_ones_are_fewer():
    for quick in (False, True):
        for found in table("gems3_adaptive").groups(quick):
            found.validate()
    assert len(table("gems3_adaptive").groups(True)) < len(table("gems3_adaptive").groups(False))
