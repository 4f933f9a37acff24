import numpy as np
import pytest

from lodbench.datasets_gen.finest import SEGMENTS, finest
from lodbench.datasets_gen.nurbs import ball, quilt
from lodbench.datasets_gen.patches import cup
from lodbench.datasets_gen.surfaces import BezierPatches, GeometryImage, NurbsModel
from lodbench.datasets_gen.triangles import icosphere


def casteljau(points, u, v):
    """One point of a patch (4, 4, 3), by repeated interpolation."""
    for t in (u, v):
        rows = points
        while len(rows) > 1:
            rows = rows[:-1] * (1 - t) + rows[1:] * t
        points = rows[0]
    return points


def test_a_mesh_is_itself():
    mesh = icosphere(1)
    assert finest(mesh) is mesh


def test_bezier_patches_are_evaluated_on_their_lattice():
    patches = cup()
    mesh = finest(patches)
    side = SEGMENTS + 1
    assert mesh.vertex_count == len(patches.points) * side**2
    assert mesh.triangle_count == len(patches.points) * 2 * SEGMENTS**2
    grid = mesh.positions.reshape(-1, side, side, 3)
    for patch, i, j in ((0, 0, 0), (1, 7, 20), (2, SEGMENTS, 5)):
        expected = casteljau(patches.points[patch].astype(float), i / SEGMENTS, j / SEGMENTS)
        assert np.abs(grid[patch, i, j] - expected).max() < 1e-6


def test_rational_ball_lies_on_its_sphere_and_a_quilt_has_every_surface():
    assert finest(quilt(2, 3, 2)).triangle_count == 2 * 3 * 2 * (2 * SEGMENTS) ** 2
    radius = np.linalg.norm(finest(ball()).positions.astype(float), axis=1)
    assert np.ptp(radius) < 1e-6 * radius.max()


def test_geometry_image_has_all_its_samples():
    points = np.random.default_rng(0).random((5, 5, 3))
    mesh = finest(GeometryImage(points, np.broadcast_to([0.0, 0.0, 1.0], (5, 5, 3))))
    assert mesh.vertex_count == 25 and mesh.triangle_count == 32


@pytest.mark.parametrize("empty", [BezierPatches(np.zeros((0, 4, 4, 3))), NurbsModel(())])
def test_nothing_gives_nothing(empty):
    assert finest(empty).triangle_count == 0
