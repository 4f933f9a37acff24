from pathlib import Path

from lodbench.harness.record.record import GroupRecord, RunRecord
from lodbench.harness.report.dices import SHOWN, dice_pictures


def record(table, dataset):
    return RunRecord(Path(), {}, [GroupRecord("g", table, "n", dataset, "d", {}, {})])


def test_the_first_model_is_shown_with_dices_of_each_size(device):
    found = list(dice_pictures(record("rc13_6_15", "rational_torus"), (80, 64), device))
    files = [picture["file"] for picture, _ in found]
    assert files == [f"dices_{k}_rational_torus.png" for k in range(len(SHOWN))]
    assert all(pixels.shape == (64, 80, 3) and pixels.std() > 5 for _, pixels in found)
    counts = [
        int(picture["caption"].split(": ")[1].split()[0].replace(",", "")) for picture, _ in found
    ]
    assert counts[0] > counts[1] > counts[2] > counts[3] > counts[5] > 0


def test_a_run_without_the_table_has_no_such_pictures(device):
    for table, dataset in (("rc13_6_2", "rational_torus"), ("rc13_6_15", "sphere_10")):
        assert not list(dice_pictures(record(table, dataset), (80, 64), device))
