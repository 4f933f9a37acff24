from pathlib import Path

import pytest

from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.report.tessellations import tessellation_pictures


def record(*groups):
    found = [
        GroupRecord("g", "t", "n", dataset, "d", {}, {}, subjects={"s": SubjectRecord("s", system)})
        for dataset, system in groups
    ]
    return RunRecord(Path(), {}, found)


def test_first_patches_are_shown_at_falling_levels(device):
    run = record(("sphere_10", "pattern"), ("cup_26", "gst"), ("pot_32", "vst"))
    found = list(tessellation_pictures(run, (80, 64), device))
    assert [picture["file"] for picture, _ in found] == [f"level_{k}_cup_26.png" for k in range(6)]
    assert [pixels.shape for _, pixels in found] == [(64, 80, 3)] * 6
    assert "13,248 triangles" in found[1][0]["caption"]
    assert [picture["level"] for picture, _ in found] == [*range(6)]
    assert all(pixels.std() > 5 for _, pixels in found)


@pytest.mark.parametrize("groups", [(), (("sphere_10", "pattern"),), (("cup_26", "unknown"),)])
def test_a_run_without_patches_has_no_such_pictures(device, groups):
    assert not list(tessellation_pictures(record(*groups), (80, 64), device))
