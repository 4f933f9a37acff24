import pytest

from lodbench.harness.plan.table import table
from tests.harness.records import group, rows_of, subject


def test_real_shader_rows_name_the_driver_and_flag_a_single_sample():
    theirs = subject("gl_tessellation", [40.0], driver="a driver")
    found = group(
        subject("pattern", [0.01] * 10), theirs, table="real_shaders", work="refine and draw"
    )
    rows, _ = rows_of("real_shaders", found)
    assert rows["gl_tessellation"]["driver"] == "a driver"
    assert rows["gl_tessellation"]["reason"] == "one sample: over 30 s"
    assert rows["pattern"]["ratio_to_gl_tessellation"] == pytest.approx(4000)
    assert rows["pattern"]["frame_fps"] == pytest.approx(100)
    found.facts["work"] = "refine"
    assert rows_of("real_shaders", found)[0]["pattern"]["frame_fps"] is None


def test_real_shaders_quick_run_leaves_out_what_takes_a_software_driver_minutes():
    made = table("real_shaders")
    assert max(group.facts.get("segments", 0) for group in made.groups(True)) == 16
    assert max(group.facts.get("segments", 0) for group in made.groups(False)) == 64
