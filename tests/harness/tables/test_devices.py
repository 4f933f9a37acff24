from types import SimpleNamespace

from lodbench.harness.plan.table import Entry
from lodbench.harness.record.record import SubjectRecord
from lodbench.harness.tables import devices
from lodbench.kernels.opencl import Device


def test_every_driver_for_the_processor_takes_its_turn_in_every_group():
    found = devices.runtimes()
    assert found and next(iter(found)).startswith("PoCL")
    for name in found.values():
        assert Device.open(name).facts.name
    for group in devices.groups(True):
        group.validate()
        assert group.same and [subject.name for subject in group.subjects] == list(found)


def test_bytes_are_compared_with_those_of_the_first_that_has_any():
    def row(label):
        return devices.own(Entry(None, group, group.subjects[label], {}))

    found = {
        "failed": None, "a": {"digest": "1", "picture": "p"}, "b": {"digest": "1", "picture": "q"},
        "c": {"digest": "2"},
    }  # fmt: skip
    subjects = {label: SubjectRecord(label, quality=quality) for label, quality in found.items()}
    group = SimpleNamespace(subjects=subjects)
    assert [row(label)["same_bytes"] for label in found] == [None, True, True, False]
    assert [row(label)["same_picture"] for label in found] == [None, True, False, None]
