import time

import numpy as np
import pytest

from lodbench.kernels.opencl.timeline import Timeline
from lodbench.kernels.system import run


class Event:
    """A finished device command of so many nanoseconds."""

    class profile:  # noqa: N801 - the name that pyopencl gives it
        start = 1_000
        end = 4_000


def test_timeline_sums_events_of_one_stage():
    timeline = Timeline()
    timeline.add("vertex", Event())
    timeline.add("geometry", Event())
    timeline.add("vertex", Event())
    assert timeline.stage_s == {}, "an event has no time before the wait"
    timeline.collect()
    assert timeline.stage_s == pytest.approx({"vertex": 6e-6, "geometry": 3e-6})
    assert timeline.total_s == pytest.approx(9e-6)


def test_timeline_collects_each_event_once():
    timeline = Timeline()
    timeline.add("vertex", Event())
    assert timeline.collect().collect().total_s == pytest.approx(3e-6)


def test_timeline_keeps_the_order_in_which_stages_first_ran():
    timeline = Timeline()
    with timeline.host("upload"):
        pass
    for stage in ("vertex", "geometry", "vertex"):
        timeline.add(stage, Event())
    assert list(timeline.collect().stage_s) == ["upload", "vertex", "geometry"]


def test_timeline_counts_a_host_block_that_failed():
    timeline = Timeline()
    with pytest.raises(KeyError), timeline.host("build"):
        raise KeyError
    assert timeline.stage_s["build"] >= 0.0


def test_frame_leaves_out_what_a_subject_does_before_its_work(device, monkeypatch):
    now = [0.0]
    monkeypatch.setattr(time, "perf_counter", lambda: now[0])

    class Subject:
        output = ()

        def enqueue(self, frame, timeline):
            with timeline.untimed():
                now[0] += 7
            with timeline.host("call"):
                now[0] += 2

    timeline = run(device, Subject())
    assert (timeline.wall_s, timeline.stage_s, timeline.untimed_s) == (2, {"call": 2}, 7)


def test_timeline_reads_the_events_of_a_real_device(device):
    timeline = Timeline()
    device.fill(timeline, "clear", device.allocate("words", 1 << 20, np.uint32), 0)
    device.wait()
    assert 0.0 < timeline.collect().stage_s["clear"] < 10.0
