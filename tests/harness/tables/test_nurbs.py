import pytest

from lodbench.harness.plan.registry import systems
from lodbench.harness.plan.table import table
from tests.harness.records import group, rows_of, subject

TABLES = (
    "nurbs_basis", "nurbs_exactness", "nurbs_grids",
    "rc13_6_2", "rc13_6_3_to_6_6", "rc13_6_7_to_6_10", "rc13_6_11_to_6_14", "rc13_6_15",
)  # fmt: skip


@pytest.mark.parametrize("name", TABLES)
def test_every_group_is_valid_and_quick_ones_are_fewer(name):
    quick, full = table(name).groups(True), table(name).groups(False)
    for found in full:
        found.validate()
    assert 0 < len(quick) < len(full)


def test_grids_are_compared_by_points_per_second():
    counters = {"triangles": 1000, "vertices": 4000, "surfaces": 1, "quads": 81}
    found = group(
        subject("stair", [0.001] * 10, counters=counters, system="uniform_nurbs"),
        subject("numpy_nurbs", [0.004] * 10, counters=counters),
        table="nurbs_grids",
    )
    rows, _ = rows_of("nurbs_grids", found)
    assert rows["stair"]["vertices_per_s"] == pytest.approx(4e6)
    assert rows["stair"]["ratio_to_numpy_nurbs"] == pytest.approx(4)
    assert rows["stair"]["quads"] == 81


def test_a_peer_on_the_host_stands_in_a_group_of_two():
    for name in ("nurbs_grids", "rc13_figures_2_10_to_2_13"):
        for found in table(name).groups(False):
            kinds = [systems()[one.system].runs_on for one in found.subjects]
            assert "host" not in kinds or (len(kinds) == 2 and found.warm), found.name


def test_ways_to_evaluate_basis_functions_are_compared_by_their_stage():
    counters = {"triangles": 1000, "vertices": 4000, "side_samples": 2000}
    found = group(
        *(
            subject(name, [{"basis": s, "vertex": 0.5}] * 10, counters=counters)
            for name, s in (("stair", 1e-6), ("triangle", 2e-6), ("cox_de_boor", 4e-6))
        ),
        table="nurbs_basis",
    )
    rows, _ = rows_of("nurbs_basis", found)
    assert rows["stair"]["basis_ratio_to_cox_de_boor"] == pytest.approx(4)
    assert rows["triangle"]["basis_ratio_to_cox_de_boor"] == pytest.approx(2)
    assert rows["cox_de_boor"]["basis_ratio_to_cox_de_boor"] is None
    assert rows["stair"]["ns_per_sample"] == pytest.approx(0.5)


def test_culling_says_what_it_leaves_and_what_it_loses():
    none = {"triangles": 3200, "quads": 100, "quads_kept": 100, "quads_culled": 0, "quads_lost": 0}
    light = none | {"triangles": 1600, "quads_kept": 50, "quads_culled": 50, "quads_lost": 5}
    found = group(
        subject("none", [0.004] * 10, counters=none, system="rpns"),
        subject("light", [0.002] * 10, counters=light, system="rpns"),
        table="rc13_6_3_to_6_6",
    )
    rows, _ = rows_of("rc13_6_3_to_6_6", found)
    assert (rows["light"]["share_left"], rows["light"]["share_lost"]) == (0.5, 0.1)
    assert rows["light"]["ratio_to_none"] == pytest.approx(2)
    assert (rows["none"]["share_left"], rows["none"]["share_lost"]) == (1, 0)
    assert rows["light"]["whole_fps"] == pytest.approx(500)


def test_a_figure_stands_beside_its_limit():
    def told(value, limit):
        return {"lost": {"value": value, "limit": limit, "looked_at": "9 KSQuads culled"}}

    found = group(
        subject("certified", [], exact=told(0, 0)), subject("light", [], exact=told(0.07, None)),
        subject("wrong", [], exact=told(0.1, 0)), subject("broken", [], exact=told(None, 0)),
        subject("left out", [], status="skipped"),
        table="nurbs_exactness", quantity="lost",
    )  # fmt: skip
    rows, _ = rows_of("nurbs_exactness", found)
    assert [row["kept"] for row in rows.values()] == [True, None, False, False, None]
    assert rows["light"]["value"] == 0.07 and rows["light"]["looked_at"] == "9 KSQuads culled"
    assert {row["what"] for row in rows.values()} == {"visible samples lost by culling, share"}
