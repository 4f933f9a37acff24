from pathlib import Path

import numpy as np

from lodbench.harness.plan import table as tables
from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.report import compared, pictures


def subject(label, system="quadric_clustering", status="ok", **more):
    return SubjectRecord(label, system, status, params={"cells": 5}, **more)


def group(table, *subjects):
    found = GroupRecord("g", table, "n", "icosphere_3", "d", {}, {})
    found.subjects = {one.label: one for one in subjects}
    return found


def test_the_first_group_of_each_such_table_is_drawn_subject_by_subject(device, monkeypatch):
    monkeypatch.setattr(pictures, "SIZE", (80, 64))
    ours = subject("quadric", quality={"rms_error": 0.0123})
    theirs = subject("vertex_average", "vertex_average")
    first = group("dt07_grids", ours, theirs, subject("broken", status="failed"))
    record = RunRecord(Path(), {}, [group("dt07_timing", ours), first, group("dt07_grids", ours)])
    found = list(pictures._compared(record, device))
    names = [picture["file"] for picture, _ in found]
    assert names == [f"grid_{number}_icosphere_3.png" for number in range(2)]
    assert {picture["series"] for picture, _ in found} == {"grid"}
    caption = found[0][0]["caption"]
    assert caption.startswith("icosphere_3, quadric: ")
    assert caption.endswith(" triangles, RMS error 0.012 of the diagonal")
    assert not np.array_equal(found[0][1], found[1][1])


def test_tables_that_are_drawn_exist():
    assert set(compared.TABLES) <= set(tables.tables())
