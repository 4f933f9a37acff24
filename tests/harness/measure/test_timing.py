import numpy as np

from lodbench.harness.measure import timing
from lodbench.harness.measure.budget import Budget
from lodbench.harness.measure.timing import interleave, quota
from lodbench.kernels.system import Timeline


def frame(wall=0.0):
    timeline = Timeline()
    timeline.wall_s = wall
    return lambda: timeline


def test_quota_slow_subjects_take_fewer_samples():
    assert quota(0.1, None) == (3, 10)
    assert quota(0.001, None) == (3, timing.MOST_SAMPLES)
    assert quota(2.5, None) == (1, 3)
    assert quota(2.5, 20) == (1, 3)
    assert quota(31.0, None) == (0, 1)
    assert quota(0.1, 5) == (3, 5)


def test_interleave_takes_turns_and_starts_to_count_at_the_same_turn():
    taken = list(interleave({"a": frame(), "b": frame()}, {"a": 0.1, "b": 3.0}, samples=4))
    assert [(s.subject, s.turn) for s in taken if s.warmup] == [("a", 1), ("a", 2)]
    counted = [(s.subject, s.turn) for s in taken if not s.warmup]
    assert counted == [("a", 3), ("b", 3), ("a", 4), ("b", 4), ("a", 5), ("b", 5), ("a", 6)]


def test_interleave_leaves_out_a_subject_whose_first_frame_was_its_only_sample():
    taken = list(interleave({"a": frame(), "b": frame()}, {"a": 0.1, "b": 40.0}, samples=2))
    assert {sample.subject for sample in taken} == {"a"}


def test_interleave_drops_a_subject_that_gives_up():
    left = iter([Timeline(), None])
    taken = list(interleave({"a": lambda: next(left), "b": frame()}, {"a": 0.1, "b": 0.1}))
    assert [sample.subject for sample in taken].count("a") == 1
    assert [sample.subject for sample in taken].count("b") == 12


def test_interleave_with_no_time_left_still_gives_every_subject_one_counted_sample():
    taken = list(interleave({"a": frame(), "b": frame()}, {"a": 1, "b": 1}, budget=Budget(0.0)))
    assert [s.subject for s in taken if not s.warmup] == ["a", "b"]


def test_peak_memory_sees_what_was_freed_again():
    peak = timing.PeakMemory()
    np.ones(1 << 22)  # 32 MiB, written and gone
    growth = peak.growth_bytes()
    assert growth is None or growth > 30 << 20
