import numpy as np
import pytest

from lodbench.harness.report import statistics
from lodbench.harness.report.statistics import paired_ratio


def test_summary_gives_quartiles():
    found = statistics.summary([4.0, 1.0, 3.0, 2.0, 5.0])
    assert found == statistics.Summary(5, 3.0, 1.0, 2.0, 4.0)
    assert found.few
    assert statistics.summary([]) is None


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
    assert paired_ratio({3: 2.0}, {3: 1.0}) == statistics.Ratio(1, 2.0, None, None)
    assert paired_ratio({3: 2.0}, {4: 1.0}) is None
    assert statistics.unpaired_ratio([2.0], [1.0, 1.0]).median == 2.0


def test_noise_says_what_it_costs_to_believe_a_median_that_chance_may_have_moved():
    quiet = [1.0] * 10
    assert statistics.noise(quiet, quiet, 0.0) == ""
    wide = [1, 1, 1, 2, 2, 2, 3, 3]  # the median is 2, its interval 1 to 3
    assert statistics.noise(wide, wide, 0.0) == "off by up to 50%: samples vary"
    assert statistics.noise(wide * 200, wide * 200, 0.0) == "", (
        "enough samples make up for their spread"
    )
    assert statistics.noise([1.0, 1.0, 1.5], [1.0] * 3, 0.0) == (
        "off by up to 50%: samples vary, 3 samples"
    )
    assert statistics.noise([1.0], [1.0], 0.0) == ""


SLOWED = [1.0] * 4 + [1.3] * 16  # most samples took 30 % longer than the least


def test_disturbance_costs_what_the_median_is_above_the_least_sample():
    starved = [1.0] * 12 + [0.4] * 8
    assert statistics.noise(SLOWED, starved, 0.0) == (
        "off by up to 30%: 8 of 20 samples got less CPU time than the rest"
    )
    assert statistics.noise(SLOWED, SLOWED, 0.2) == (
        "off by up to 30%: other processes took 20% of the machine"
    )
    assert statistics.noise(SLOWED, SLOWED, 0.0) == ""


def test_disturbance_that_changed_nothing_is_no_noise_unless_it_left_nothing_undisturbed():
    quiet = [1.0] * 10
    assert statistics.noise(quiet, [2.0] * 6 + [0.5] * 4, 0.3) == ""
    assert statistics.noise(quiet, quiet, 0.5) == (
        "off by nobody knows how much: other processes took 50% of the machine"
    )


@pytest.mark.parametrize(("wall", "said"), [(5e-4, False), (5e-3, True)])
def test_cpu_clock_says_nothing_of_frames_under_a_millisecond(wall, said):
    # it ticks in steps longer than such a frame: some have no CPU time at all
    cpu = [wall] * 12 + [0.0] * 8
    walls = [wall * slower for slower in SLOWED]
    assert ("less CPU time" in statistics.noise(walls, cpu, 0.0)) == said


def test_off_is_the_farther_end_of_the_interval():
    assert statistics.off([1.0] * 10) == 0
    assert statistics.off([0.9] * 2 + [1.0] * 6 + [1.2] * 2) == pytest.approx(0.2)
    assert statistics.off([1.0, 1.0, 1.4]) == pytest.approx(0.4)  # too few: the farthest sample
    assert statistics.off([1.0]) is statistics.off([]) is None


def test_log_slope_of_a_power_is_its_exponent():
    x = np.array([1e5, 1e6, 1e7])
    slope, low, high = statistics.log_slope(x, 3e-9 * x**1.5)
    assert slope == pytest.approx(1.5)
    assert low <= slope <= high
    assert statistics.log_slope([1.0, 1.0], [2.0, 3.0]) is None


def test_interval_of_a_slope_holds_the_true_one_in_95_of_100_cases():
    random = np.random.default_rng(0)
    x = np.geomspace(1e3, 1e6, 4)
    lines = [statistics.log_slope(x, x * np.exp(random.normal(0, 0.1, 4))) for _ in range(2000)]
    held = np.mean([line[1] <= 1 <= line[2] for line in lines if line is not None])
    assert held == pytest.approx(0.95, abs=0.02)


def test_paired_ratio_is_the_median_and_not_the_mean():
    skewed = paired_ratio({0: 1.0, 1: 1.0, 2: 10.0}, {0: 1.0, 1: 1.0, 2: 1.0})
    assert skewed is not None and skewed.median == 1
