import numpy as np
import pytest
from scipy.interpolate import BSpline

from lodbench.datasets_gen import nurbs


def sample(surface, count=17):
    """Points (count, count, 3) on a grid of the whole domain."""

    def basis(knots, degree, size):
        places = np.linspace(knots[degree], knots[-degree - 1], count)
        return BSpline(knots, np.eye(size), degree)(places)

    u = basis(surface.knots_u, surface.degree_u, surface.points.shape[0])
    v = basis(surface.knots_v, surface.degree_v, surface.points.shape[1])
    weighted = np.concatenate(
        [surface.points * surface.weights[..., None], surface.weights[..., None]], axis=2
    )
    homogeneous = np.einsum("ai,bj,ijk->abk", u, v, weighted)
    return homogeneous[..., :3] / homogeneous[..., 3:]


def test_cylinder_is_exact():
    points = sample(nurbs.cylinder(radius=2.0).surfaces[0])
    assert np.linalg.norm(points[..., :2], axis=-1) == pytest.approx(2.0, abs=1e-12)


def test_ball_is_exact():
    assert np.linalg.norm(sample(nurbs.ball().surfaces[0]), axis=-1) == pytest.approx(
        1.0, abs=1e-12
    )


def test_quilt_neighbours_share_their_edge_to_the_bit():
    model = nurbs.quilt(2, 3, 4)
    assert len(model.surfaces) == 6
    grid = [[model.surfaces[row * 3 + column].points for column in range(3)] for row in range(2)]
    for row in range(2):
        for column in range(2):
            assert np.array_equal(grid[row][column][-1], grid[row][column + 1][0])
    for column in range(3):
        assert np.array_equal(grid[0][column][:, -1], grid[1][column][:, 0])
    assert len(np.unique(model.surfaces[0].knots_u)) - 1 == 4


def test_torus_is_exact():
    points = sample(nurbs.torus(2.0, 0.5).surfaces[0])
    around = np.linalg.norm(points[..., :2], axis=-1) - 2
    assert np.hypot(around, points[..., 2]) == pytest.approx(0.5, abs=1e-12)


def test_mixed_degrees_are_all_degrees_with_knots_that_repeat():
    surfaces = nurbs.mixed_degrees().surfaces
    assert [(s.degree_u, s.degree_v) for s in surfaces] == [(k, 8 - k) for k in range(1, 8)]
    assert all(s.rational for s in surfaces)
    for surface in surfaces:
        inner = surface.knots_u[surface.degree_u + 1 : -surface.degree_u - 1]
        assert np.unique(inner, return_counts=True)[1].max() == surface.degree_u


def test_body_is_closed_and_one_smooth_spline():
    rows, columns = 3, 4
    model = nurbs.body(rows, columns, (4, 5))
    assert len(model.surfaces) == 12 and model.span_count == 12 * 20
    for k, surface in enumerate(model.surfaces):
        row, column = divmod(k, columns)
        beside = model.surfaces[row * columns + (column + 1) % columns]
        above = model.surfaces[(row + 1) % rows * columns + column]
        assert np.array_equal(surface.points[:, -1], beside.points[:, 0])
        assert np.array_equal(surface.points[-1], above.points[0])
        # one tangent on both sides
        assert np.diff(surface.points[:, -2:], axis=1) == pytest.approx(
            np.diff(beside.points[:, :2], axis=1), abs=1e-12
        )
    assert len(nurbs.body().surfaces) == 88 and nurbs.body().span_count == 11_616
