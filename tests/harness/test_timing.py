import numpy as np
import pytest

from lodbench.harness import timing
from lodbench.harness.budget import Budget
from lodbench.harness.timing import interleave, paired_ratio, quota
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


def test_budget_remembers_that_something_was_left_undone(monkeypatch):
    now = [5.0]
    monkeypatch.setattr(timing.time, "perf_counter", lambda: now[0])
    budget = Budget(2.0)
    assert (budget.left, budget.stops(), budget.cut) == (2.0, False, False)
    now[0] = 8.0
    assert (budget.left, budget.cut) == (-1.0, False), "nothing was asked for yet"
    assert (budget.stops(), budget.cut) == (True, True)


def test_summary_gives_quartiles():
    found = timing.summary([4.0, 1.0, 3.0, 2.0, 5.0])
    assert found == timing.Summary(5, 3.0, 1.0, 2.0, 4.0)
    assert found.few
    assert timing.summary([]) is None


def test_paired_ratio_cancels_a_drift_that_both_share():
    drift = dict(enumerate(np.linspace(1, 3, 12)))
    ratio = paired_ratio({t: 2 * s for t, s in drift.items()}, drift)
    assert ratio.n == 12
    assert ratio.median == ratio.low == ratio.high == pytest.approx(2.0)


def test_paired_ratio_interval_holds_the_true_ratio_and_is_the_same_for_the_same_seed():
    rng = np.random.default_rng(0)
    a = dict(enumerate(3.0 * rng.lognormal(sigma=0.1, size=30)))
    b = dict(enumerate(rng.lognormal(sigma=0.1, size=30)))
    first, second = paired_ratio(a, b, seed=7), paired_ratio(a, b, seed=7)
    assert first == second
    assert first.low < 3.0 < first.high
    assert first.high - first.low < 0.6


def test_ratio_of_few_samples_has_no_interval():
    assert paired_ratio({3: 2.0}, {3: 1.0}) == timing.Ratio(1, 2.0, None, None)
    assert paired_ratio({3: 2.0}, {4: 1.0}) is None
    assert timing.unpaired_ratio([2.0], [1.0, 1.0]).median == 2.0


def test_peak_memory_sees_what_was_freed_again():
    peak = timing.PeakMemory()
    np.ones(1 << 22)  # 32 MiB, written and gone
    growth = peak.growth_bytes()
    assert growth is None or growth > 30 << 20


def test_noise_names_an_uncertain_median_starvation_and_others():
    quiet = [1.0] * 10
    assert timing.noise(quiet, quiet, 0.0) == ""
    wide = [1, 1, 1, 2, 2, 2, 3, 3]
    assert "median uncertain" in timing.noise(wide, wide, 0.0)
    assert timing.noise(wide * 200, wide * 200, 0.0) == "", (
        "enough samples make up for their spread"
    )
    assert "less CPU time" in timing.noise(quiet, [2.0] * 6 + [0.5] * 4, 0.0)
    assert "other processes took 40%" in timing.noise(quiet, quiet, 0.4)


def test_log_slope_of_a_power_is_its_exponent():
    x = np.array([1e5, 1e6, 1e7])
    slope, low, high = timing.log_slope(x, 3e-9 * x**1.5)
    assert slope == pytest.approx(1.5)
    assert low <= slope <= high
    assert timing.log_slope([1.0, 1.0], [2.0, 3.0]) is None


def test_paired_ratio_is_the_median_and_not_the_mean():
    skewed = paired_ratio({0: 1.0, 1: 1.0, 2: 10.0}, {0: 1.0, 1: 1.0, 2: 1.0})
    assert skewed is not None and skewed.median == 1
