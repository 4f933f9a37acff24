import pytest

from lodbench.harness.plan.table import table
from tests.harness.records import group, rows_of, subject


def projected(label, cores, chain):
    counters = {"chain_s": chain, "work_s": 0.012, "chain_share": chain / 0.012, "launches": 11}
    params = {"cores": cores, "accumulate": label.split("_")[0]}
    return subject(label, [0.05] * 4, system="projected_cores", counters=counters, params=params)


def rows():
    system = "quadric_clustering"
    return rows_of(
        "scaling",
        group(
            subject("private", [0.006] * 6, system=system),
            subject("slabs", [0.009] * 6, system=system),
            subject("slabs_one_core", [0.018] * 6, system=system),
            projected("private_on_16", 16, 0.005),
            projected("slabs_on_16", 16, 0.001),
            projected("slabs_on_64", 64, 0.0005),
            table="scaling",
        ),
    )


def test_a_projection_has_no_wall_time_and_is_compared_with_one_on_as_many_cores():
    found, made = rows()
    row = found["slabs_on_16"]
    assert (row["how"], row["cores"], row["chain_s"]) == ("projected", 16, 0.001)
    assert row["wall_s"] is None and row["samples"] is None and row["ratio_to_private"] is None
    assert row["chain_ratio_to_private"] == pytest.approx(5)
    assert found["slabs_on_64"]["chain_ratio_to_private"] is None
    assert any("no measurement" in note for note in made["notes"])


def test_measured_rows_have_their_cores_and_no_chain():
    found, _ = rows()
    assert found["slabs"]["how"] == "measured"
    assert found["slabs_one_core"]["cores"] == 1
    assert found["slabs"]["ratio_to_private"] == pytest.approx(2 / 3)
    assert found["slabs"]["chain_s"] is None


@pytest.mark.parametrize("quick", [True, False])
def test_groups_project_both_ways_to_the_same_cores_scans_first(quick):
    groups = table("scaling").groups(quick)
    assert "armadillo" in groups[1 - quick].dataset
    for found in groups:
        found.validate()
        labels = {one.name for one in found.subjects}
        assert {
            f"{way}_on_{cores}" for way in ("private", "slabs") for cores in (2, 16, 64)
        } <= labels
    assert len({str(found.config()) for found in groups}) == len(groups)
