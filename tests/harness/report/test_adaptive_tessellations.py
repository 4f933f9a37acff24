from pathlib import Path

from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.report.adaptive_tessellations import adaptive_pictures


def record(*groups):
    found = [
        GroupRecord("g", "t", "n", dataset, "d", {}, {}, subjects={"s": SubjectRecord("s", system)})
        for dataset, system in groups
    ]
    return RunRecord(Path(), {}, found)


def test_first_adaptive_model_is_shown_by_every_method_and_test(device):
    run = record(("pot_32", "vst"), ("cup_26_x3", "dabt"))
    found = list(adaptive_pictures(run, (80, 64), device))
    assert [picture["file"] for picture, _ in found] == [
        f"adaptive_{k}_{name}_cup_26.png"
        for k, name in enumerate(["vst", "semi_adaptive", "dabt", "dabt", "dabt", "dabt"])
    ]
    assert all(pixels.shape == (64, 80, 3) and pixels.std() > 5 for _, pixels in found)
    assert "53,248 triangles" in found[0][0]["caption"]


def test_a_run_without_adaptive_tessellations_has_no_such_pictures(device):
    assert not list(adaptive_pictures(record(("pot_32", "vst")), (80, 64), device))
