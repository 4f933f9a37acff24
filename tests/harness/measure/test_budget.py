import pytest

from lodbench.harness.measure import budget
from lodbench.harness.measure.budget import Budget


@pytest.fixture
def clock(monkeypatch):
    """The seconds that the clock shows, in a list of one."""
    now = [100.0]
    monkeypatch.setattr(budget.time, "perf_counter", lambda: now[0])
    return now


def test_budget_runs_down_and_below_zero(clock):
    made = Budget(5)
    clock[0] += 2
    assert made.left == 3
    clock[0] += 4
    assert made.left == -1


@pytest.mark.parametrize(
    ("spent", "needed", "stops"),
    [(0, 0, False), (4, 0.9, False), (4, 1.1, True), (5, 0, True), (6, 0, True)],
)
def test_budget_stops_what_it_has_no_time_for_and_remembers(clock, spent, needed, stops):
    made = Budget(5)
    clock[0] += spent
    assert not made.cut, "nothing was left undone yet"
    assert made.stops(needed) is stops
    assert made.cut is stops
    clock[0] = 100.0
    assert made.stops() is False
    assert made.cut is stops, "what was left undone stays so"
