import numpy as np
import pytest

from lodbench.datasets_gen import read
from lodbench.datasets_gen.triangles import torus
from lodbench.harness.baselines.simplify_file import Params, prepare, write_copies
from lodbench.harness.plan.table import table
from lodbench.harness.tables import out_of_core
from lodbench.kernels.system import run
from tests.harness.records import group, rows_of, subject


def test_rows_have_rate_memory_and_whether_the_bytes_are_the_same():
    counters = {"triangles": 10, "triangles_read": 1000, "file_bytes": 9, "peak_bytes": 70}
    rows, _ = rows_of(
        "out_of_core",
        group(
            subject("in_core", [0.1] * 5, counters={**counters, "same_bytes": 1}),
            subject(
                "out_of_core", [0.2] * 5,
                counters={**counters, "same_bytes": 0, "memory_limit_bytes": 80},
            ),
            subject("out_of_core_target", [0.2] * 5, counters=counters),
            table="out_of_core", copies=2,
        ),
    )  # fmt: skip
    assert [row["same"] for row in rows.values()] == ["yes", "no", None]
    assert rows["out_of_core"]["ratio_to_in_core"] == pytest.approx(0.5)
    assert rows["out_of_core"]["triangles_per_s"] == pytest.approx(5000)
    assert (rows["out_of_core"]["memory_limit_bytes"], rows["out_of_core"]["peak_bytes"]) == (
        80,
        70,
    )
    assert rows["in_core"]["memory_limit_bytes"] is None


def test_a_hundred_million_triangles_are_asked_for(monkeypatch):
    monkeypatch.delenv(out_of_core.HUGE, raising=False)
    assert len(table("out_of_core").groups(False)) == 5
    monkeypatch.setenv(out_of_core.HUGE, "1")
    assert len(table("out_of_core").groups(True)) == 1
    huge = table("out_of_core").groups(False)[-1]
    assert huge.facts["copies"] == 1000
    assert [s.name for s in huge.subjects] == ["out_of_core"]
    huge.validate()


def test_copies_stand_side_by_side(tmp_path):
    mesh = torus(12, 8)
    write_copies(tmp_path / "a.ply", mesh, 5)
    found = read.read_mesh(tmp_path / "a.ply")
    parts = found.positions.reshape(5, -1, 3)
    assert np.array_equal(found.triangles.reshape(5, -1, 3)[4], mesh.triangles + 4 * 96)
    assert np.array_equal(parts[0], mesh.positions)
    boxes = np.array([[part.min(0), part.max(0)] for part in parts])
    apart = (boxes[:, None, 0] > boxes[None, :, 1]) | (boxes[None, :, 0] > boxes[:, None, 1])
    assert (apart.any(-1) | np.eye(5, dtype=bool)).all()


def test_subject_streams_what_is_larger_than_its_memory_and_says_how_large_it_was(device):
    made = prepare(device, torus(160, 100), Params(20, memory="64M", copies=16, measured=True))
    run(device, made)
    counters = made.counters()
    assert made.check().passed
    assert counters["triangles_read"] == 512_000 and counters["same_bytes"] == 1
    assert 0 < counters["peak_bytes"] < counters["memory_limit_bytes"] == 64 << 20
