import numpy as np
import pytest

from lodbench.kernels.exactness import verdict


@pytest.mark.parametrize(
    ("figures", "value", "passed"),
    [
        ((5e-7, np.deg2rad(0.02), "all"), 0.5, True),
        ((1e-7, np.deg2rad(0.2), "all"), 2, False),
        ((1e-7, 0.0, "all", 3), 3, False),
        ((np.nan, 0.0, "all"), np.nan, False),
        ((1e-7, 0.0, "all", np.inf), np.inf, False),
    ],
)
def test_the_worst_share_of_a_limit_decides_and_both_figures_stay(figures, value, passed):
    check = verdict(*figures)
    assert check.passed is passed and check.value == pytest.approx(value, nan_ok=True)
    assert check.what.endswith(", all")
    expected = {"position": figures[0], "normal": np.rad2deg(figures[1])}
    assert check.parts == pytest.approx(expected, nan_ok=True)
