import pytest

from lodbench.harness.plan.table import table
from lodbench.harness.tables.pareto import CALLED, GENERATED, KINDS, SLOW
from tests.harness.records import group, rows_of, subject


def judged(label, rms, **more):
    return subject(label, [0.002] * 5, quality={"rms_error": rms}, **more)


def test_rows_have_errors_as_shares_of_fast_simplifications():
    made = group(
        judged("quadric_clustering", 0.003), judged("fast_simplification", 0.002),
        subject("vtk_binned_decimation", [0.001] * 5), table="pareto",
    )  # fmt: skip
    rows, _ = rows_of("pareto", made)
    assert rows["quadric_clustering"]["rms_error_share"] == pytest.approx(1.5)
    assert rows["fast_simplification"]["rms_error_share"] == 1
    assert rows["vtk_binned_decimation"]["rms_error_share"] is None
    assert rows["quadric_clustering"]["rms_error_share_of_careful"] is None
    careful = group(
        judged("hybrid_call", 0.003), judged("fast_simplification_careful", 0.002), table="pareto"
    )
    shares = [row["rms_error_share_of_careful"] for row in rows_of("pareto", careful)[0].values()]
    assert shares == pytest.approx([1.5, 1])


def test_groups_are_each_mesh_at_each_target_and_fewer_in_a_quick_run():
    quick, whole = table("pareto").groups(True), table("pareto").groups(False)
    assert {made.dataset for made in whole} == set(KINDS)
    assert len(whole) == 3 * len(KINDS) > len(quick)
    for made in (*quick, *whole):
        made.validate()
        labels = {one.label or one.system for one in made.subjects}
        assert made.dataset in CALLED or {"quadric_clustering", "octree"} <= labels
        assert {"fast_simplification", "fast_simplification_careful"} <= labels
        assert {"hybrid_call", "auto_call", "edge_collapse_call"} <= labels
        if made.dataset in GENERATED:
            assert not labels & set(SLOW)
