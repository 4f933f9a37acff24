import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.kernels.stages.camera import (
    distance_to_show,
    fit_box,
    fit_points,
    look_at,
    orbit,
    pixel_rows,
    to_screen,
)
from lodbench.kernels.stages.raster_reference import transform


def clip(view, points):
    """(n, 3) x y z after the division, and w."""
    rows = np.c_[np.asarray(points, float), np.ones(len(points))] @ view.world_to_clip.T
    return rows[:, :3] / rows[:, 3:], rows[:, 3]


def test_look_at_puts_the_target_in_the_middle_and_up_upwards():
    view = look_at((1, 2, 5), (0, 1, 0), size=(64, 48))
    (target, above), w = clip(view, [(0, 1, 0), (0, 1.5, 0)])
    np.testing.assert_allclose(target[:2], 0, atol=1e-12)
    assert above[1] > 0 and abs(above[0]) < 1e-12
    assert (w > 0).all()


def test_look_at_maps_near_and_far_to_the_ends_of_depth():
    view = look_at((0, 0, 0), (0, 0, -1), near=0.5, far=20)
    ends, _ = clip(view, [(0, 0, -0.5), (0, 0, -20)])
    np.testing.assert_allclose(ends[:, 2], (-1, 1), atol=1e-12)


def test_look_at_sees_its_vertical_angle_and_the_image_ratio():
    view = look_at((0, 0, 0), (0, 0, -1), fov_y=60, size=(200, 100))
    (top, right), _ = clip(view, [(0, np.tan(np.pi / 6), -1), (2 * np.tan(np.pi / 6), 0, -1)])
    np.testing.assert_allclose((top[1], right[0]), 1, atol=1e-12)


@pytest.mark.parametrize("up", [(0, 1, 0), (0, 0, 1)])
def test_look_at_along_its_up_is_still_a_camera(up):
    view = look_at(np.multiply(up, 3), (0, 0, 0), up=up)
    assert np.isfinite(view.world_to_clip).all()
    assert abs(np.linalg.det(view.world_to_clip)) > 0


def test_orbit_places_the_eye():
    np.testing.assert_allclose(orbit((1, 0, 0), 2, 0, 0).eye, (1, 0, 2))
    np.testing.assert_allclose(orbit((0, 0, 0), 2, 90, 0).eye, (2, 0, 0), atol=1e-12)
    np.testing.assert_allclose(orbit((0, 0, 0), 2, 0, 90).eye, (0, 2, 0), atol=1e-12)


points = st.lists(st.tuples(*[st.floats(-1e3, 1e3, width=32)] * 3), min_size=1, max_size=12)
directions = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda d: np.linalg.norm(d) > 0.1)


@settings(max_examples=200, deadline=None)
@given(points, directions, st.integers(1, 500), st.integers(1, 500))
def test_fit_points_has_all_points_in_the_image_and_touches_its_margin(
    points, direction, width, height
):
    view = fit_points(points, direction, (width, height), margin=1.25)
    seen, w = clip(view, points)
    assert (w > 0).all()
    assert (np.abs(seen[:, :2]) <= 0.8 + 1e-6).all()  # 1 / margin
    assert (np.abs(seen[:, 2]) <= 1).all()


def test_fit_points_comes_as_near_as_it_can():
    rng = np.random.default_rng(3)
    for shape in ((1, 1, 1), (5, 1, 1), (0.1, 4, 1)):
        cloud = rng.normal(size=(100, 3)) * shape
        seen, _ = clip(fit_points(cloud, (1, 0.4, 2), (300, 200), margin=1.0), cloud)
        low, high = seen[:, :2].min(0), seen[:, :2].max(0)
        assert np.isclose(np.maximum(-low, high).max(), 1, atol=1e-6)
        np.testing.assert_allclose(-low, high, atol=1e-6)  # in the middle, both ways


def test_fit_box_sees_the_corners_of_the_box():
    view = fit_box((-1, -2, -3), (4, 5, 6), size=(100, 100), margin=1.0)
    corners = [(x, y, z) for x in (-1, 4) for y in (-2, 5) for z in (-3, 6)]
    seen, _ = clip(view, corners)
    assert np.isclose(np.abs(seen[:, :2]).max(), 1, atol=1e-6)


def test_to_screen_gives_sub_pixels_with_row_0_on_top():
    view = look_at((0, 0, 0), (0, 0, -1), fov_y=90, size=(80, 60), near=1, far=3)
    # the centre, the top edge, the near and the far plane
    rows = transform(
        np.array([(0, 0, -1), (0, 1, -1), (0, 0, -3)], np.float32), to_screen(view)
    ).astype(float)
    screen = rows[:, :3] / rows[:, 3:]
    np.testing.assert_allclose(screen[0, :2], (40 * 256, 30 * 256), rtol=1e-6)
    np.testing.assert_allclose(screen[1, 1], 0, atol=1e-2)
    np.testing.assert_allclose(screen[[0, 2], 2], (0, 1), atol=1e-6)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"fov_y": 180}, "fov_y: expected degrees between 0 and 180, got 180"),
        ({"size": (0, 5)}, "size: expected 1 to 16384 pixels per side, got 0 x 5"),
        ({"eye": (0, 0, 0)}, "target: expected a finite point other than the eye"),
        ({"near": 2, "far": 1}, "near, far: expected 0 < near < far, got 2.0, 1.0"),
    ],
)
def test_look_at_refuses_what_is_no_camera(change, text):
    with pytest.raises(ValueError, match=text):
        look_at(**({"eye": (0, 0, 1), "target": (0, 0, 0)} | change))


def test_fit_refuses_what_is_no_box():
    with pytest.raises(ValueError, match="low, high: expected two corners"):
        fit_box((0, 0, 1), (1, 1, 0))
    with pytest.raises(ValueError, match="points: expected finite"):
        fit_points(np.zeros((0, 3)))
    with pytest.raises(ValueError, match="direction: expected a finite vector"):
        fit_points([(0, 0, 0)], (0, 0, 0))


@pytest.mark.parametrize("size", [(64, 48), (48, 64)])
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_distance_to_show_is_the_least_from_which_all_is_seen(size, scale):
    points = np.random.default_rng(0).normal(size=(200, 3)) * (1, 3, 2) * scale
    target, direction = np.array([0.1, 0.2, -0.1]) * scale, np.array([0.3, 0.4, 0.8])
    away = distance_to_show(points, target, direction, size, margin=1.0)
    for share, inside in ((1.0001, True), (0.99, False)):
        eye = target + share * away * direction / np.linalg.norm(direction)
        placed, _ = clip(look_at(eye, target, size=size), points)
        assert (np.abs(placed[:, :2]).max() <= 1) == inside
    assert distance_to_show(target[None], target, direction) == 1.0


def test_pixel_rows_bring_points_to_pixels_from_the_middle():
    view = look_at((0, 0, 5), (0, 0, 0), fov_y=90, size=(200, 100))
    for point, expected in (((0, 0, 0), (0, 0)), ((5, 0, 0), (50, 0)), ((1, -4, 1), (12.5, -50))):
        x, y, w = (np.dot(row, (*point, 1)) for row in pixel_rows(view))
        assert w > 0 and np.allclose((x / w, y / w), expected)
