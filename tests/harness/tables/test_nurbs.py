import pytest

from lodbench.harness.plan.table import table
from tests.harness.records import group, rows_of, subject

TABLES = ("nurbs_grids",)


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
