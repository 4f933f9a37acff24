from pathlib import Path

import numpy as np
import pytest

from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.report import refinements
from lodbench.harness.report.refinements import refinement_pictures

SIZE = (80, 64)
WAVE = {"displacement": "sine", "amplitude": 0.05, "waves": 12.0}


def group(dataset, *subjects, reference=None):
    found = GroupRecord("g", "t", "n", dataset, "d", {}, {"reference": reference})
    found.subjects = {subject.label: subject for subject in subjects}
    return found


def compared(segments, status="ok", system="pattern", **quality):
    quality = quality or {"rms_difference": 0.1 / segments}
    params = {"segments": segments, **WAVE}
    return SubjectRecord(f"s{segments}", system, status, params=params, quality=quality)


@pytest.fixture
def drawn(device):
    def draw(*groups):
        found = refinement_pictures(RunRecord(Path(), {}, list(groups)), SIZE, device)
        return {picture["file"]: (picture["caption"], pixels) for picture, pixels in found}

    return draw


def test_wave_is_drawn_by_the_coarsest_the_middle_and_the_finest_pattern(drawn):
    reference = SubjectRecord("s32", "pattern", "ok", params={"segments": 32, **WAVE})
    others = [compared(n) for n in (16, 1, 2, 4, 8)]
    found = drawn(
        group("plane_2", *others, reference="s32"),
        group("icosphere_0", *others, reference, compared(3, "failed"), reference="s32"),
    )
    assert list(found) == [f"wave_{k}_icosphere_0.png" for k in range(3)], "of the last group"
    captions = [caption for caption, _ in found.values()]
    assert captions[0] == (
        "icosphere_0, 12 waves per diagonal, 1 segment: 20 triangles, RMS difference 0.1 of the diagonal"
    )
    assert "4 segments: 320 triangles" in captions[1]
    assert "16 segments: 5,120 triangles" in captions[2]
    coarse, _, fine = (pixels for _, pixels in found.values())
    assert coarse.shape == (64, 80, 3) and not np.array_equal(coarse, fine)


def test_patterns_too_large_to_draw_are_left_out(drawn, monkeypatch):
    monkeypatch.setattr(refinements, "MOST_TRIANGLES", 20 * 4**2)
    found = drawn(group("icosphere_0", *map(compared, (2, 4, 8)), reference="s8"))
    assert len(found) == 2
    monkeypatch.setattr(refinements, "MOST_TRIANGLES", 1)
    assert drawn(group("icosphere_0", compared(2), reference="s8")) == {}


def test_curved_sphere_stands_beside_the_flat_one_and_fills_more(drawn):
    found = drawn(group("torus_36", SubjectRecord("s", "pn_triangles", "ok")))
    (flat, first), (curved, second) = found.values()
    assert "pattern" in flat and "pn_triangles" in curved
    background = first[:, :1]  # a row has one colour where nothing is drawn
    covered = [(pixels != background).any(axis=2).sum() for pixels in (first, second)]
    assert covered[1] > 1.05 * covered[0]


def test_creases_have_a_share_of_the_meshs_own_sharpness(drawn):
    tagged = SubjectRecord("s", "st_triangles", "ok")
    found = drawn(
        group("icosphere_0", tagged), group("spool_72", tagged), group("spool_98", tagged)
    )
    assert [caption.split(", ")[3].split(":")[0] for caption, _ in found.values()] == [
        "sharpness up to 0", "sharpness up to 0.5", "sharpness up to 1",
    ]  # fmt: skip
    assert all(file.endswith("spool_72.png") for file in found), "the first with tags of its own"
    smooth, _, sharp = (pixels for _, pixels in found.values())
    assert not np.array_equal(smooth, sharp)


def test_depth_tags_are_shown_of_each_kind(drawn):
    found = drawn(group("icosphere_1", SubjectRecord("s", "adaptive_patterns", "ok")))
    assert [file.split("_")[2] for file in found] == ["curvature", "distance", "screen"]
    pictures = [pixels for _, pixels in found.values()]
    assert not np.array_equal(pictures[0], pictures[2])
    assert all(": 80 triangles" not in caption for caption, _ in found.values()), "they refine"


def test_distances_from_a_reference_are_no_waves(drawn):
    made = group("icosphere_0", *map(compared, (2, 4, 8)), reference="s8")
    made.config["nearest"] = True
    assert drawn(made) == {}


def test_run_without_refinement_has_no_such_pictures(drawn):
    assert drawn(group("icosphere_0", SubjectRecord("s", "quadric_clustering", "ok"))) == {}
    assert drawn(group("quilt_4", compared(2), reference="s4")) == {}, "no mesh"
