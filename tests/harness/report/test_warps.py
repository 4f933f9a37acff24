from pathlib import Path

import numpy as np
import pytest

from lodbench.harness.plan.focus import Focus
from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord, plain
from lodbench.harness.report.warps import warp_pictures

SIZE = (80, 64)


def group(focus, *subjects):
    config = {} if focus is None else {"focus": plain(focus)}
    found = GroupRecord("g", "t", "n", "icosphere_3", "d", {}, config)
    found.subjects = {subject.label: subject for subject in subjects}
    return found


def simplified(label, status="ok", quality=None, **params):
    params = {"target_count": 400, **params}
    return SubjectRecord(label, "quadric_clustering", status, params=params, quality=quality)


@pytest.fixture
def drawn(device):
    def draw(*groups):
        found = warp_pictures(RunRecord(Path(), {}, list(groups)), SIZE, device)
        return {picture["file"]: (picture["caption"], pixels) for picture, pixels in found}

    return draw


def test_each_subject_of_the_first_region_and_of_the_first_eye_is_drawn(drawn):
    even = simplified("even", quality={"rms_error_inside": 0.0123, "rms_pixels": None})
    fine = simplified("region_8", regions=[[1.0, 0.0, 0.0, 0.3, 8.0]])
    eye = Focus((2, 0.5, 0.5))
    found = drawn(
        group(None, even),
        group(Focus((1, 0.5, 0.5), 0.1), even, fine, simplified("broken", "failed")),
        group(Focus((0, 0.5, 0.5), 0.1), even),
        group(eye, simplified("view", quality={"rms_pixels": 3.21}, view=np.eye(4).tolist())),
    )
    names = ["region_warp_0", "region_warp_1", "view_warp_0"]
    assert list(found) == [f"{name}_icosphere_3.png" for name in names]
    captions = [caption for caption, _ in found.values()]
    assert captions[0].startswith("icosphere_3, even: ")
    assert captions[0].endswith(" triangles, RMS error 0.012 of the diagonal inside")
    assert captions[1].endswith(" triangles")
    assert captions[2].endswith("RMS error 3.2 pixels at 1280 x 1024")
    pixels = [pixels for _, pixels in found.values()]
    assert pixels[0].shape == (64, 80, 3)
    assert not np.array_equal(pixels[0], pixels[1])


def test_runs_without_warps_have_no_such_pictures(drawn):
    assert drawn(group(None, simplified("even"))) == {}
