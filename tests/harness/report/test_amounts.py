import pytest

from lodbench.harness.report.amounts import amount, rounded


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"), (1.0, "1"), (1234.56, "1,235"), (17777.7, "17,780"), (0.00012345, "0.0001234"),
        (0.000012345, "1.234e-5"), (2.5e12, "2.5e12"), (-0.5, "-0.5"), (99999.9, "100,000"),
        (float("inf"), "inf"),
    ],
)  # fmt: skip
def test_rounded_keeps_four_digits(value, text):
    assert rounded(value) == text


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (None, "s", "–"), ("", "", "–"), (True, "", "yes"), ("torus", "", "torus"),
        (1310720, "", "1,310,720"), (12.5, "", "12.5"), ((90, 60, 30), "", "90 × 60 × 30"),
        (0.01234567, "s", "12.35 ms"), (2.5e-7, "s", "250 ns"), (3.0, "s", "3 s"), (0, "s", "0 s"),
        (51480000, "B", "51.48 MB"), (12, "B", "12 B"), (2.7e10, "B/s", "27 GB/s"),
        (9.9e10, "flop/s", "99 Gflop/s"), (-0.0125, "s", "-12.5 ms"), (-2e6, "B", "-2 MB"),
    ],
)  # fmt: skip
def test_amount_chooses_a_readable_unit(value, unit, text):
    assert amount(value, unit) == text
