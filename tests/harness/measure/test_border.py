import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.measure.quality import measure
from tests.harness.measure.test_quality import square


def test_border_error_is_how_far_the_border_moved():
    sheet = square()
    drawn_in = TriangleMesh(sheet.positions * np.float32(0.9), sheet.triangles)
    # the far corner goes from (1, 1) to (0.9, 0.9), of a diagonal of the square root of 2
    assert measure(sheet, drawn_in, samples=10)["border_error"] == pytest.approx(0.1)
    coarse = square(cells=1)
    assert measure(sheet, coarse, samples=10)["border_error"] == pytest.approx(0, abs=1e-7)
    ball = icosphere(1)
    assert measure(ball, sheet, samples=10)["border_error"] is None
    assert measure(sheet, ball, samples=10)["border_error"] is None
