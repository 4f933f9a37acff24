"""The figures of a group: recorded beside their limits, and a subject over one of them fails."""

import pytest

from lodbench.harness.measure import exact
from lodbench.harness.measure.figure import Figure
from lodbench.harness.measure.run import Session
from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.plan.table import tables
from lodbench.harness.record.folder import open_folder
from lodbench.harness.record.record import read_run
from lodbench.kernels.opencl import Unsupported
from tests.harness import fake


@pytest.fixture
def measured(tmp_path, device, monkeypatch):
    fake.install(monkeypatch.setattr)

    def refused(seen):
        raise Unsupported("needs wings, subject has none")

    found = {
        "small": lambda seen: Figure(0.5, 1, "4 triangles"),
        "large": lambda seen: Figure(2, 1),
        "nan": lambda seen: Figure(float("nan"), 1),
        "told": lambda seen: Figure(9, None),
        "same": lambda seen: Figure(0.0 if seen.first is seen.prepared else 1.0, 1),
        "refused": refused,
    }
    quantities = {name: exact.Quantity(f"the {name} one", call) for name, call in found.items()}
    monkeypatch.setattr(exact, "QUANTITIES", quantities)

    def run(*names):
        session = Session(device, open_folder(device, {}, out=tmp_path / "run"), samples=2)
        group = Group("one", (Subject("fake"), Subject("other")), exact=names, once=True)
        session.measure([("t", group)], quiet=True)
        session.close()
        return read_run(tmp_path / "run").groups[0].subjects

    return run


def test_figures_are_recorded_with_their_limits(measured):
    found = measured("small", "told", "same")
    assert found["fake"].status == "ok"
    assert found["fake"].exact == {
        "small": {"value": 0.5, "limit": 1, "looked_at": "4 triangles"},
        "told": {"value": 9, "limit": None, "looked_at": ""},
        "same": {"value": 0.0, "limit": 1, "looked_at": ""},
    }
    assert found["other"].exact["same"]["value"] == 1


@pytest.mark.parametrize(("name", "value"), [("large", "2"), ("nan", "nan")])
def test_a_figure_over_its_limit_fails_its_subject(measured, name, value):
    found = measured("small", name)["fake"]
    assert found.status == "failed" and found.exact["small"]["value"] == 0.5
    assert found.reason == f"the {name} one: expected at most 1, got {value}"


def test_what_cannot_be_measured_is_skipped(measured):
    found = measured("refused")["fake"]
    assert (found.status, found.reason) == ("skipped", "needs wings, subject has none")


def test_tables_ask_for_quantities_that_there_are():
    asked = {name for t in tables().values() for group in t.groups(False) for name in group.exact}
    assert asked == set(exact.QUANTITIES)
