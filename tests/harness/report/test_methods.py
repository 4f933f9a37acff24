from pathlib import Path

import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.report.methods import distances, method_pictures, tiled

SIZE = (80, 64)


def subject(label, system, status="ok", **params):
    off = {"rms_error": 0.0123}
    return SubjectRecord(label, system, status, params={"target_count": 60, **params}, quality=off)


def drawn(device, reduction, *subjects):
    group = GroupRecord("g", "pareto", "n", "icosphere_3", "d", {"reduction": reduction}, {})
    group.subjects = {one.label: one for one in subjects}
    return list(method_pictures(RunRecord(Path(), {}, [group]), SIZE, device))


def test_every_method_is_in_one_strip_once(device):
    ours = subject("quadric_clustering", "quadric_clustering")
    once = subject("edge_collapse_one_core", "edge_collapse")
    called = subject("auto_call", "simplify_call", method="auto")
    kept = subject("hybrid_call", "simplify_call", method="hybrid")
    ((picture, pixels),) = drawn(
        device, 0.99, ours, once, called, kept, subject("broken", "octree", "failed")
    )
    assert picture["file"] == "methods_icosphere_3.png"
    assert pixels.shape == (64, 160, 3)
    assert "quadric_clustering (" in picture["caption"] and "hybrid_call (60" in picture["caption"]
    assert "one_core" not in picture["caption"] and "auto_call" not in picture["caption"]
    assert drawn(device, 0.9, ours) == []


def test_distances_are_from_the_input_in_its_diagonals():
    ball = icosphere(3).bare()
    larger = TriangleMesh(1.1 * ball.positions, ball.triangles)
    assert distances(ball, ball).max() < 1e-6
    assert distances(ball, larger).mean() == pytest.approx(0.1 / ball.diagonal, rel=0.03)


def test_rows_are_filled_with_white():
    one = np.zeros((4, 5, 3), np.uint8)
    assert tiled([one] * 5).shape == (8, 20, 3)
    assert tiled([one] * 5)[4:, 5:].min() == 255
