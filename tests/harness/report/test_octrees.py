from pathlib import Path

import numpy as np

from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.report.octrees import octree_pictures

SIZE = (80, 64)


def group(*subjects):
    found = GroupRecord("g", "t", "n", "icosphere_3", "d", {}, {})
    found.subjects = {subject.label: subject for subject in subjects}
    return found


def simplified(system, label, status="ok", quality=None, **params):
    return SubjectRecord(
        label, system, status, params={"target_count": 300, **params}, quality=quality
    )


def drawn(device, *groups):
    found = octree_pictures(RunRecord(Path(), {}, list(groups)), SIZE, device)
    return {picture["file"]: (picture["caption"], pixels) for picture, pixels in found}


def test_a_grid_is_drawn_beside_octrees_of_its_group(device):
    off = {"rms_error": 0.0123}
    grid = simplified("quadric_clustering", "grid", quality=off)
    boxes = simplified("octree", "boxes", quality=off)
    found = drawn(
        device,
        group(grid),
        group(simplified("octree", "broken", "failed"), grid, boxes,
              simplified("octree", "cubes", quality=off, shape="cubes")),
        group(grid, boxes),
    )  # fmt: skip
    assert list(found) == [f"octree_{number}_icosphere_3.png" for number in range(3)]
    captions = [caption for caption, _ in found.values()]
    assert captions[0].startswith("icosphere_3, grid: ")
    assert captions[1].startswith("icosphere_3, boxes: ")
    assert "RMS error 0.012 of the diagonal" in captions[2]
    pixels = [pixels for _, pixels in found.values()]
    assert pixels[0].shape == (64, 80, 3)
    assert not np.array_equal(pixels[1], pixels[2])


def test_runs_without_octrees_have_no_such_pictures(device):
    grid = simplified("quadric_clustering", "grid", quality={"rms_error": 0.01})
    assert drawn(device, group(grid)) == {}
