import pytest

from lodbench.harness.tables.dt07_octree import TABLE
from tests.harness.records import group, rows_of, subject


def test_octree_rows_have_shares_of_the_grids_errors():
    def errors(rms, largest):
        return {"rms_error": rms, "rms_error_back": rms, "max_error": largest}

    found = group(
        subject("octree", [0.002] * 5, quality=errors(1e-4, 1e-3), counters={"triangles": 100}),
        subject("quadric_clustering", [0.001] * 5, quality=errors(4e-4, 2e-3),
                counters={"triangles": 100}),
        table="dt07_octree", dataset="fandisk", triangles_in=1000, work="error",
    )  # fmt: skip
    rows, _ = rows_of("dt07_octree", found)
    assert rows["octree"]["rms_error_share"] == pytest.approx(0.25)
    assert rows["octree"]["max_error_share"] == pytest.approx(0.5)
    assert rows["quadric_clustering"]["rms_error_share"] == pytest.approx(1)
    assert rows["octree"]["ratio_to_quadric_clustering"] == pytest.approx(0.5)


def test_table_rows_have_what_was_lost_and_what_is_published():
    counters = {
        "triangles": 4000, "keys": 90, "slots": 800, "collisions": 0.11,
        "collisions_predicted": 0.1, "disagreement": 0.0,
    }  # fmt: skip

    def swept(storage):
        return group(
            subject("quadric_clustering", [0.001] * 5, counters={"triangles": 4000}),
            subject("probabilistic_octree", [0.003] * 5, counters=counters),
            table="dt07_octree", dataset="bunny_69k", storage=storage, levels=7, work="storage",
        )  # fmt: skip

    rows, _ = rows_of("dt07_octree", swept(0.08))
    row = rows["probabilistic_octree"]
    assert (row["keys"], row["slots"], row["collisions"]) == (90, 800, 0.11)
    assert row["slowdown"] == pytest.approx(3)
    assert (row["published_collisions"], row["published_slowdown"]) == (0.1, 1.2)
    assert rows["quadric_clustering"]["levels"] is None
    rows, _ = rows_of("dt07_octree", swept(0.3))
    assert rows["probabilistic_octree"].get("published_collisions") is None


@pytest.mark.parametrize("quick", [True, False])
def test_octree_groups_are_valid_and_parts_come_before_scans(quick):
    groups = TABLE.groups(quick)
    assert len({found.name for found in groups}) == len(groups)
    for found in groups:
        found.validate()
    assert groups[0].dataset == "fandisk"
