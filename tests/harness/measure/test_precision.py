import numpy as np
import pytest

from lodbench.harness.measure.precision import ENOUGH, half_width, median_interval


def test_interval_needs_six_samples():
    # five lie on one side of the median in 2 / 2**5 = 6 % of all cases: too many for 95 %
    assert median_interval([1.0] * (ENOUGH - 1)) == (None, None)
    assert median_interval([3.0, 1.0, 2.0, 6.0, 5.0, 4.0]) == (1.0, 6.0)
    assert half_width([1.0] * (ENOUGH - 1)) == np.inf


def test_interval_is_between_samples_whatever_their_order():
    # of ten, the second and the ninth: 11 / 2**10 is below 2.5 %, 56 / 2**10 is above
    assert median_interval(list(np.random.default_rng(0).permutation(10.0 * np.arange(10)))) == (
        10.0,
        80.0,
    )


@pytest.mark.parametrize("n", [6, 10, 25, 40])
@pytest.mark.parametrize("kind", ["normal", "exponential", "heavy"])
def test_interval_holds_the_median_in_95_of_100_cases_of_any_distribution(n, kind):
    rng = np.random.default_rng(n)
    values, median = {
        "normal": (rng.normal(size=(2000, n)), 0.0),
        "exponential": (rng.exponential(size=(2000, n)), np.log(2)),
        "heavy": (rng.standard_cauchy(size=(2000, n)), 0.0),
    }[kind]
    ends = [median_interval(list(row)) for row in values]
    held = np.mean([low <= median <= high for low, high in ends])  # type: ignore[operator]
    assert held > 0.94


def test_half_width_is_relative_to_the_middle():
    assert half_width([0.9] * 5 + [1.1] * 5) == pytest.approx(0.1)
    assert half_width([2.0] * 10) == 0
    assert half_width([0.0] * 10) == 0
