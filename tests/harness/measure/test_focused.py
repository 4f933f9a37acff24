import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.measure.focused import measure
from lodbench.harness.plan.focus import Focus
from lodbench.kernels import simplify_mesh

pytest.importorskip("igl")
FINE = icosphere(4)


def plate(z):
    points = [[0, 0, z], [1, 0, z], [1, 1, z], [0, 1, z]]
    return TriangleMesh(points, [[0, 1, 2], [0, 2, 3]])


def test_ball_parts_errors_and_triangles():
    result = simplify_mesh(None, FINE, cells=9).mesh
    found = measure(FINE, result, Focus((1, 0.5, 0.5), 0.2), samples=4000)
    everywhere = measure(FINE, result, Focus((0.5, 0.5, 0.5), 5.0), samples=4000)
    assert found["triangles_inside"] + found["triangles_outside"] == result.triangle_count
    assert 0 < found["triangles_inside"] < found["triangles_outside"]
    assert found["rms_error_inside"] > 0 < found["rms_error_outside"]
    assert everywhere["triangles_outside"] == 0
    assert everywhere["rms_error_outside"] is None
    assert "rms_pixels" not in found


def test_finer_region_is_closer_inside_and_farther_outside():
    focus = Focus((1, 0.5, 0.5), 0.15)
    even = simplify_mesh(None, FINE, target_count=800, method="quadric_clustering").mesh
    warped = simplify_mesh(
        None, FINE, target_count=even.triangle_count, regions=[focus.region(FINE, 8)]
    ).mesh
    a, b = (measure(FINE, mesh, focus, samples=4000) for mesh in (even, warped))
    assert b["rms_error_inside"] < a["rms_error_inside"]
    assert b["rms_error_outside"] > a["rms_error_outside"]


def test_pixels_are_distances_over_depth():
    # a plate beside the one that was, a tenth of its side away, seen straight on from a hundred sides away
    eye = Focus((0.5, 0.5, 100.0))
    reference = TriangleMesh(
        [*plate(0).positions, [0, 0, 1]], plate(0).triangles
    )  # a box of 1 x 1 x 1
    found = measure(reference, plate(-0.1), eye, samples=500)
    per_unit = np.linalg.norm(eye.view(reference).world_to_clip[1, :3]) * 512 / 100
    assert found["rms_pixels"] == pytest.approx(0.1 * per_unit, rel=1e-3)
    assert found["rms_pixels_near"] == pytest.approx(found["rms_pixels"])
    assert found["rms_pixels_far"] is None, "nothing is farther than the median"
    assert found["triangles_inside"] == 2


def test_nothing_has_no_error():
    empty = TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int))
    assert measure(FINE, empty, Focus((0, 0, 0))) == {}
