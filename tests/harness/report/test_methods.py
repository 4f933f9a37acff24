from pathlib import Path

import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.report.methods import distances, method_pictures, named, rivals

SIZE = (100, 100)


def subject(label, system, status="ok", triangles=60, off=0.0123, **params):
    return SubjectRecord(
        label, system, status, params={"target_count": 60, **params}, quality={"rms_error": off},
        counters={"triangles": triangles},
    )  # fmt: skip


def group(*subjects, table="pareto", dataset="icosphere_3", **facts):
    found = GroupRecord("g", table, "n", dataset, "d", facts, {})
    found.subjects = {one.label: one for one in subjects}
    return found


RIVALS = (
    subject("quadric_clustering", "quadric_clustering", off=0.03),
    subject("edge_collapse", "edge_collapse", off=0.01),
    subject("hybrid_call", "simplify_call", off=0.02, method="hybrid"),
)


def test_rivals_are_verified_alike_and_each_once_nearest_first():
    others = (
        subject("edge_collapse_one_core", "edge_collapse", off=0.001),
        subject("edge_collapse_call", "simplify_call", off=0.001),
        subject("broken", "octree", "failed", off=0.001),
        subject("larger", "octree", triangles=90, off=0.001),
        subject("the_same", "octree", off=0.01),
    )
    found = rivals(group(*RIVALS, *others))
    assert [one.label for one in found] == ["edge_collapse", "hybrid_call", "quadric_clustering"]
    assert rivals(group(*RIVALS, triangles_in=10**7)) == []
    assert rivals(group()) == []


def test_pictures_are_of_the_fewest_triangles_with_names_in_them(device):
    more = [subject(one.label, one.system, triangles=90, **one.params) for one in RIVALS]
    groups = [group(*RIVALS, table="t"), group(*more), group(*RIVALS), group(*RIVALS[:2])]
    found = list(method_pictures(RunRecord(Path(), {}, groups), SIZE, device))
    assert [picture["name"] for picture, _ in found] == [
        "edge_collapse", "hybrid_call", "quadric_clustering",
    ]  # fmt: skip
    assert {picture["table"] for picture, _ in found} == {"pareto"}
    assert found[0][0]["file"] == "methods_0_icosphere_3.png"
    assert "by edge_collapse: 60 triangles, RMS error 1.0e-2" in found[0][0]["caption"]
    assert all(pixels.shape == (84 + 20, 80, 3) for _, pixels in found)
    assert list(method_pictures(RunRecord(Path(), {}, groups[-1:]), SIZE, device)) == []


def test_a_name_is_drawn_under_the_picture_and_fits():
    blank = np.full((100, 80, 3), 7, np.uint8)
    made = named(blank, "a_name_of_forty_letters_that_is_too_long", "864, error 1e-3")
    assert (made[:100] == 7).all()
    band = made[100:]
    assert (band < 90).any()
    assert not (band[:, -1] < 200).any(), "cut off"
    assert not np.array_equal(made, named(blank, "another", "864, error 1e-3"))


def test_distances_are_from_the_input_in_its_diagonals():
    ball = icosphere(3).bare()
    larger = TriangleMesh(1.1 * ball.positions, ball.triangles)
    assert distances(ball, ball).max() < 1e-6
    assert distances(ball, larger).mean() == pytest.approx(0.1 / ball.diagonal, rel=0.03)
