"""Whole frames: with raster and shading, beside samples without or in place of them."""

import numpy as np
import pytest

from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.measure.run import PATH_ROUNDS, Session, _zoomed
from lodbench.harness.measure.trial import Trial
from lodbench.harness.plan.group import Draw, Group, Subject
from lodbench.harness.record.folder import open_folder
from lodbench.harness.record.record import SAMPLES, read_rows, read_run
from lodbench.harness.report import rows as table_rows
from lodbench.kernels.stages.paths import CameraPath

SIZE = (64, 48)
DRAWING = {"vertex_transform", "raster", "fragment"}


@pytest.fixture
def measure(device, tmp_path):
    def measured(*subjects, samples=2, **options):
        folder = open_folder(device, {}, out=tmp_path / "run")
        session = Session(device, folder, samples=samples)
        try:
            session.measure([("t", Group("sphere_10", subjects, **options))], quiet=True)
        finally:
            session.close()
        (group,) = read_run(folder).groups
        return group, read_rows(folder / SAMPLES)

    return measured


def vbo(**options):
    return Subject("static_vbo", {"segments": 4}, **options)


def pattern(**options):
    return Subject("pattern", {"segments": 4}, **options)


def test_frames_drawn_apart_follow_the_samples_in_turns_of_their_own(measure):
    apart = Draw(SIZE, apart=True)
    group, rows = measure(vbo(draw=apart), pattern(draw=apart), pattern(label="undrawn"))
    counted = [
        (row["kind"], row["subject"])
        for row in rows
        if row["kind"] in ("sample", "frame") and not row["warmup"]
    ]
    samples = [("sample", name) for name in ("static_vbo", "pattern", "undrawn")] * 2
    frames = [("frame", name) for name in ("static_vbo", "pattern")] * 2
    assert counted == samples + frames
    for name in ("static_vbo", "pattern"):
        subject = group.subjects[name]
        assert not DRAWING & set(subject.stages)
        assert all(DRAWING < set(row["stage_s"]) for row in subject.frames)
        assert len(subject.frame_s) == 2
        row = table_rows.measured(group, subject)
        assert row["frame_fps"] == pytest.approx(1 / row["frame_s"])
        assert row["frames"] == 2
    assert table_rows.measured(group, group.subjects["undrawn"])["frame_fps"] is None


def test_samples_have_no_view_where_frames_are_drawn_apart(device):
    trial = Trial(pattern(draw=Draw(SIZE, apart=True)))
    trial.enter(icosphere(1), lambda: device, {}, lambda kind, **row: None, keep_mesh=False)
    assert trial.view.view is None
    assert trial.seen.view is not None
    assert (trial.seen.view.width, trial.seen.view.height) == SIZE


def test_group_that_runs_once_counts_the_first_frame_and_takes_no_other(measure):
    group, rows = measure(vbo(), pattern(draw=Draw(SIZE, apart=True)), samples=5, once=True)
    samples = [(row["subject"], row["warmup"]) for row in rows if row["kind"] == "sample"]
    assert samples == [("static_vbo", False), ("pattern", False)]
    assert len(group.subjects["pattern"].frame_s) == 5


def test_sample_that_draws_is_a_whole_frame(measure):
    group, _ = measure(pattern(draw=Draw(SIZE)), vbo())
    drawn = group.subjects["pattern"]
    assert DRAWING < set(drawn.stages)
    assert not drawn.frames
    assert not DRAWING & set(group.subjects["static_vbo"].stages)


def test_subject_without_a_surface_on_the_device_is_not_drawn(measure):
    group, _ = measure(
        Subject("numpy_pattern", {"segments": 4}, "apart", draw=Draw(SIZE, apart=True)),
        Subject("numpy_pattern", {"segments": 4}, "within", draw=Draw(SIZE)),
    )
    apart, within = group.subjects["apart"], group.subjects["within"]
    assert (apart.status, apart.frames) == ("ok", [])
    assert apart.frame_reason == "needs a surface on the device to draw, subject leaves none"
    assert (within.status, within.reason) == ("skipped", apart.frame_reason)
    assert table_rows.measured(group, apart)["frame_s"] is None


class LeavesNothingNear:
    """A frame of `static_vbo` that, from some frame on, leaves no surface to draw."""

    def __init__(self, prepared, frames):
        self._prepared, self._left = prepared, frames

    def __getattr__(self, name):
        return getattr(self._prepared, name)

    @property
    def output(self):
        return self._prepared.output if self._left >= 0 else ()

    def enqueue(self, frame, timeline):
        self._left -= 1
        self._prepared.enqueue(frame, timeline)


@pytest.mark.parametrize(("apart", "status"), [(True, "ok"), (False, "skipped")])
def test_frame_that_leaves_nothing_to_draw_has_no_time(device, apart, status):
    trial = Trial(pattern(draw=Draw(SIZE, apart=apart)))
    trial.enter(icosphere(1), lambda: device, {}, lambda kind, **row: None, keep_mesh=False)
    trial.prepared = LeavesNothingNear(trial.prepared, frames=1)
    frame = trial.whole_frame if apart else trial.frame
    assert frame() is not None
    assert frame() is None
    assert trial.status == status
    why = trial.facts["frame_reason"] if apart else trial.reason
    assert why == "needs a surface on the device to draw, subject leaves none"


def test_draw_is_part_of_what_decides_a_measurement():
    plain, drawn = (Group("sphere_10", (vbo(draw=draw),)).config() for draw in (None, Draw(SIZE)))
    assert plain != drawn


def test_group_may_be_seen_magnified():
    near = Group("sphere_10", (Subject("drawn_mesh"),), zoom=4.0)
    far = Group("sphere_10", (Subject("drawn_mesh"),))
    assert near.config() != far.config()
    surface = near.found().surface
    small, large = (_zoomed(surface, zoom).world_to_clip for zoom in (1.0, 4.0))
    np.testing.assert_allclose(large, np.diag([4, 4, 1, 1]) @ small)
    assert _zoomed(surface, None) is None


def test_every_view_of_a_camera_path_is_drawn_by_all_in_turn_and_recorded(measure):
    apart, path = Draw(SIZE, apart=True), CameraPath("orbit", 5)
    levels = Subject("pattern", {"segments": 4, "levels": 3}, draw=apart)
    group, rows = measure(vbo(draw=apart), levels, path=path)
    frames = [row for row in rows if row["kind"] == "frame"]
    steps = [(row["subject"], row["step"]) for row in frames]
    once = [(name, step) for step in range(5) for name in ("static_vbo", "pattern")]
    assert steps == once * PATH_ROUNDS
    assert group.config["path"] == {"kind": "orbit", "frames": 5}
    pattern_row = group.subjects["pattern"]
    assert {step: len(found) for step, found in pattern_row.path_s.items()} == dict.fromkeys(
        range(5), PATH_ROUNDS
    )
    drawn = [row["triangles"] for row in frames if row["subject"] == "pattern"][:5]
    assert drawn[0] == 10 * 16 and drawn[2] == min(drawn) == 10, "coarser from farther away"
    assert {row["triangles"] for row in frames if row["subject"] == "static_vbo"} == {160}
    assert len(pattern_row.frame_s) == 5 * PATH_ROUNDS, "turns that ratios are taken between"


def test_subject_that_remembers_starts_every_round_anew(measure, monkeypatch):
    from lodbench.kernels.refine.pattern.host import Pattern

    resets = []
    monkeypatch.setattr(Pattern, "reset", lambda self: resets.append(1), raising=False)
    measure(pattern(draw=Draw(SIZE, apart=True)), path=CameraPath("turntable", 3))
    assert len(resets) == 1 + PATH_ROUNDS
