import numpy as np
import pytest

from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.plan.focus import Focus


def test_ball_is_in_shares_of_the_box_and_of_the_diagonal():
    mesh = icosphere(2)
    low, high = mesh.box
    ball = Focus((1, 0.5, 0), 0.1)
    expected = (high[0], (low[1] + high[1]) / 2, low[2])
    assert ball.place(mesh) == pytest.approx(expected)
    assert ball.region(mesh, 7) == pytest.approx((*expected, 0.1 * mesh.diagonal, 7))


def test_eye_looks_at_the_middle():
    mesh = icosphere(2)
    view = Focus((2, 0.5, 0.5)).view(mesh)
    assert view.eye == pytest.approx(Focus((2, 0.5, 0.5)).place(mesh))
    x, y, _, w = view.world_to_clip @ (*np.mean(mesh.box, axis=0), 1)
    assert (x / w, y / w) == pytest.approx((0, 0), abs=1e-6)
