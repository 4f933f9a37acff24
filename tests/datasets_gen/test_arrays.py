import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from lodbench.datasets_gen.arrays import FAR, checked_origin, recentred, usable
from lodbench.datasets_gen.surfaces import GeometryImage, TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, torus
from tests.tolerances import EPSILON32

MAP = np.array((4e5, 5e6, 100.0))


@pytest.mark.parametrize("dtype", [np.float32, np.float16, np.int16])
def test_points_that_float32_holds_stay_as_they_came(dtype):
    points = (np.eye(3) + 1000).astype(dtype)
    assert recentred(points)[0] is points and recentred(points)[1] is None


@pytest.mark.parametrize("offset, far", [(0.0, False), (FAR - 2, False), (FAR + 2, True)])
def test_origin_is_used_where_digits_would_be_lost(offset, far):
    points = np.eye(3) + np.array((offset, 0, 0))
    local, origin = recentred(points)
    assert (origin is not None) == far
    assert (local is points) != far
    if far:
        assert origin.tolist() == [offset, 0, 0], "the other axes lose nothing"


@pytest.mark.parametrize("extent", [1.0, 3.0, 7.5])
def test_origin_lies_in_the_middle_to_a_power_of_two_below_the_extent(extent):
    points = 1000.0 + np.array([[0, 0, 0], [1, 0.5, 0.25], [0.5, 1, 1]]) * extent
    local, origin = recentred(points)
    step = 2.0 ** np.floor(np.log2(extent))
    assert np.abs(np.min(local, 0) + np.max(local, 0)).max() <= step
    assert (origin % step == 0).all()


def test_integers_and_lists_are_map_coordinates_too():
    for points in ((np.eye(3) + MAP).astype(np.int64), (np.eye(3) + MAP).tolist()):
        local, origin = recentred(points)
        assert np.array_equal(local + origin, np.asarray(points))


@pytest.mark.parametrize("value", [np.nan, 1e39, 1.7e308])
def test_what_is_no_float32_is_refused_as_before(value):
    with pytest.raises(ValueError, match="points: expected finite"):
        TriangleMesh(np.eye(3) * value, [(0, 1, 2)])


def test_points_in_one_place_come_back():
    mesh = TriangleMesh(np.tile(MAP + 0.1, (3, 1)), [(0, 1, 2)])
    assert np.array_equal(mesh.points, np.tile(MAP + 0.1, (3, 1)))
    assert mesh.diagonal == 0


@given(
    points=arrays.arrays(
        np.float64, (5, 3), elements=st.floats(-1, 1) | st.integers(-4, 4).map(float)
    ),
    offset=st.tuples(*3 * [st.floats(-1e12, 1e12)]),
    scale=st.sampled_from([1e-6, 1.0, 1e9]),
)
def test_points_come_back_within_float32_of_their_extent(points, offset, scale):
    world = points * scale + offset
    mesh = TriangleMesh(world, [(0, 1, 2)])
    extent = np.ptp(world, axis=0).max()
    assert np.abs(mesh.points - world).max() <= FAR * EPSILON32 * extent
    again = TriangleMesh(mesh.points.astype(np.float64), mesh.triangles)
    assert np.array_equal(again.points, mesh.points), "once rounded, to the bit"


@given(points=arrays.arrays(np.float32, (4, 3), elements=st.floats(-1024, 1024, width=32)))
def test_float32_points_given_as_float64_come_back_to_the_bit(points):
    assert np.array_equal(TriangleMesh(points.astype(np.float64), [(0, 1, 2)]).points, points)


def test_meshes_made_of_a_mesh_keep_its_origin():
    from lodbench.datasets_gen.order import spatially_sorted, welded

    ball = torus(8, 6)
    mesh = TriangleMesh(ball.positions + MAP, ball.triangles)
    for made in (mesh.with_normals(), spatially_sorted(mesh), welded(mesh)):
        assert np.array_equal(np.unique(made.points, axis=0), np.unique(mesh.points, axis=0))
    assert mesh.with_origin(None).origin is None
    assert np.array_equal(mesh.with_origin((1, 2, 3)).points, mesh.positions + np.arange(1.0, 4))
    plain = icosphere(0)
    assert plain.with_origin(None) is plain and plain.points is plain.positions


def test_geometry_image_keeps_its_origin(tmp_path):
    from lodbench.datasets_gen.images import read_geometry_image, write_geometry_image

    grid = np.random.default_rng(0).random((5, 5, 3))
    normals = np.tile((0.0, 0.0, 1.0), (5, 5, 1))
    image = GeometryImage(grid + MAP, normals)
    assert np.allclose(image.positions + image.origin, grid + MAP, rtol=0, atol=EPSILON32)
    write_geometry_image(tmp_path / "image.npz", image)
    assert np.array_equal(read_geometry_image(tmp_path / "image.npz").origin, image.origin)
    write_geometry_image(tmp_path / "near.npz", GeometryImage(grid, normals))
    assert read_geometry_image(tmp_path / "near.npz").origin is None


@pytest.mark.parametrize("origin", [(1, 2), (np.nan, 0, 0), 3.0])
def test_origin_is_three_finite_numbers(origin):
    with pytest.raises(ValueError, match="origin: expected 3 finite numbers"):
        checked_origin(origin)
    assert checked_origin((0, 0, 0)) is None


@pytest.mark.parametrize(
    "values",
    [None, np.ones(3), np.ones((2, 2)), np.ones((3, 1)), [["a", "b"]] * 3, np.full((3, 2), np.nan),
     np.full((3, 2), 1e39)],
)  # fmt: skip
def test_attributes_that_do_not_fit_are_of_no_use(values):
    assert usable(values, 3, 2) is None
    assert np.array_equal(usable(np.arange(9).reshape(3, 3), 3, 2), [[0, 1], [3, 4], [6, 7]])
