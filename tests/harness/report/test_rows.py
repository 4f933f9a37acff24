import pytest

from lodbench.harness.report.rows import limit_share, measured, memory_bytes
from tests.harness.records import group, run, subject


def test_share_of_the_limit_is_taken_against_medians_not_against_one_best_sample():
    one = subject("a", [{"vertex": 0.5}] * 10, traffic={"vertex": {"bytes": 10, "flops": 0}})

    def rate(best, median):
        return {"subject": "k", "unit": "B/s", "best": best, "median": median, "samples": [best]}

    found = run(group(one))
    names = ("copy", "multiply_add", "launch_wall", "launch_event")
    rest = {name: rate(9.0, 9.0) for name in names}
    found.limits = {"device": "d", "size_bytes": 1, "fill": rate(1000.0, 40.0), **rest}
    assert limit_share(found, one) == pytest.approx(10 / 40 / 0.5)


def test_noisy_row_says_why():
    row = measured(group(others=0.5), subject("ours", [1.0] * 10))
    quiet = measured(group(others=0.5), subject("ours", [1.0] * 10))
    assert row == quiet
    found = group(subject("ours", [1.0] * 10), others=0.5)
    row = measured(found, found.subjects["ours"])
    assert (row["status"], row["samples"]) == ("noisy", 10)
    assert "50%" in row["reason"]


def test_memory_is_what_the_device_holds_or_the_highest_rise_of_a_system_on_the_host():
    held = {"input_bytes": 5, "output_bytes": 7, "scratch_bytes": 11, "stored_bytes": 1000}
    first = subject("first", [1.0], footprint={"input_bytes": 10}, peak_growth_bytes=300)
    again = subject("again", [1.0], footprint={"input_bytes": 20}, peak_growth_bytes=0)
    first.system = again.system = "package"
    other = subject("other", [1.0], footprint={"input_bytes": 10}, peak_growth_bytes=9000)
    kernels = subject("kernels", [{"vertex": 1.0}], footprint=held, peak_growth_bytes=9000)
    both = group(first, again, other, kernels)
    found = {name: memory_bytes(both, one) for name, one in both.subjects.items()}
    assert found == {"first": 310, "again": 320, "other": 9010, "kernels": 23}
    assert memory_bytes(group(one := subject("one", [1.0])), one) is None
