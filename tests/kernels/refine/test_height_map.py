import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, plane, torus
from lodbench.kernels import refine, refine_mesh
from lodbench.kernels.refine import pattern, pn_triangles, st_triangles
from lodbench.kernels.refine.texture import uv_attributes, uv_gradients
from tests.kernels.refine.test_function import distinct, made, with_uvs
from tests.kernels.refine.test_pattern import shaken, tetrahedron
from tests.tolerances import ROUNDING32

SYSTEMS = pytest.mark.parametrize("system", [pattern, pn_triangles, st_triangles])
FILTERS = pytest.mark.parametrize("map_filter", ["bilinear", "nearest"])
VALUES = np.random.default_rng(7).random((5, 8))
HIGH = {"displacement": "height_map", "amplitude": 0.05}


def smooth(count=64):
    """A map that repeats without a step: waves along both axes."""
    x, y = np.meshgrid((np.arange(count) + 0.5) / count, (np.arange(count) + 0.5) / count)
    return 0.5 + 0.25 * np.sin(2 * np.pi * x) + 0.25 * np.cos(4 * np.pi * y)


def heights(mesh):
    return mesh.positions[:, 2].astype(float)


@SYSTEMS
@FILTERS
@pytest.mark.parametrize("values", [VALUES, smooth(), VALUES[:1, :1], VALUES[:1], VALUES[:, :1]])
@pytest.mark.parametrize("segments", [1, 3, 16])
@pytest.mark.parametrize("make", [tetrahedron, lambda: shaken(icosphere(1)), lambda: torus(9, 7)])
def test_surface_agrees_with_reference(device, system, make, segments, values, map_filter):
    options = {**HIGH, "height_map": values, "map_filter": map_filter, "map_bias": 0.4}
    check = made(device, with_uvs(make()), segments, system, **options).check()
    assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"


@pytest.mark.parametrize(
    "change", [{"height_map": VALUES[::-1]}, {"map_bias": 0.1}, {"map_filter": "nearest"}]
)
def test_check_sees_another_map(device, change):  # fmt: skip
    mesh, options = with_uvs(icosphere(1)), {**HIGH, "height_map": VALUES}
    one, other = made(device, mesh, 8, **options), made(device, mesh, 8, **options | change)
    one._displacement, one._coarse.displacement = (other._displacement,) * 2
    assert not one.check().passed


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    seed=st.integers(0, 2**31), segments=st.integers(1, 17), map_filter=st.sampled_from(["bilinear", "nearest"]),
    system=st.sampled_from([pattern, pn_triangles]), offset=st.sampled_from([0, 100]),
)  # fmt: skip
def test_closed_mesh_with_shared_uvs_has_no_cracks(
    device, seed, segments, map_filter, system, offset
):
    mesh = with_uvs(shaken(icosphere(1), seed, offset), seed)
    values = np.random.default_rng(seed).random((4, 7))
    options = {**HIGH, "height_map": values, "map_filter": map_filter}
    found = made(device, mesh, segments, system, **options).result()[0]
    assert distinct(found) == mesh.triangle_count * segments**2 // 2 + 2


def test_seams_open(device):
    """Two triangles of a square, each with its own uvs: along the edge between them the map says two things."""
    square = plane(1)
    points, normals = square.positions[square.triangles], square.normals[square.triangles]
    uvs = np.repeat([[0.25, 0.5], [0.75, 0.5]], 3, axis=0)
    apart = TriangleMesh(
        points.reshape(-1, 3), np.arange(6).reshape(2, 3), normals.reshape(-1, 3), uvs
    )
    for values, count in (([[0.5, 0.5]], 25), ([[0.2, 0.8]], 25 + 5)):
        options = {**HIGH, "height_map": np.array(values)}
        found = made(device, apart, 4, **options).result()[0]
        assert len(np.unique(found.positions, axis=0)) == count


@FILTERS
@pytest.mark.parametrize("shape", [(4, 4), (4, 8), (1, 16)])
def test_plane_has_the_map_s_values_in_the_middles_of_its_pixels(device, shape, map_filter):
    values = np.random.default_rng(1).random(shape)
    options = {"displacement": "height_map", "amplitude": 0.5, "height_map": values}
    found = refine_mesh(device, plane(1), segments=32, map_filter=map_filter, **options).mesh
    x, y = found.positions[:, 0] * shape[1] - 0.5, (1 - found.positions[:, 1]) * shape[0] - 0.5
    middle = (x % 1 == 0) & (y % 1 == 0)
    assert middle.sum() == values.size
    expected = values[y[middle].astype(int), x[middle].astype(int)]  # the first row is at the top
    raised = heights(found)[middle] / (0.5 * plane(1).diagonal)
    np.testing.assert_allclose(raised, expected, atol=ROUNDING32)


def test_bilinear_is_straight_between_pixels_and_nearest_a_step(device):
    values = np.array([[0.0, 1.0]])
    options = {"displacement": "height_map", "amplitude": 0.5, "height_map": values}
    for map_filter, expected in (
        ("bilinear", lambda u: 1 - np.abs(u * 2 - 1.5)),
        ("nearest", lambda u: (u >= 0.5).astype(float)),
    ):
        found = refine_mesh(device, plane(1), segments=32, map_filter=map_filter, **options).mesh
        u = found.positions[:, 0].astype(float)
        inside = (u >= 0.25) & (u < 1)
        raised = heights(found) / (0.5 * plane(1).diagonal)
        np.testing.assert_allclose(raised[inside], expected(u[inside]), atol=ROUNDING32)


@FILTERS
@pytest.mark.parametrize("shift", [(1, 0), (0, 1), (-3, 2)])
def test_map_repeats(device, map_filter, shift):
    square = plane(2)
    moved = TriangleMesh(square.positions, square.triangles, square.normals, square.uvs + shift)
    options = {**HIGH, "height_map": VALUES[:4], "map_filter": map_filter}
    one, other = (made(device, mesh, 8, **options).result()[0] for mesh in (square, moved))
    assert np.array_equal(one.positions, other.positions)
    np.testing.assert_allclose(one.normals, other.normals, atol=ROUNDING32)


def test_map_repeats_without_a_step_at_its_border(device):
    wide = plane(1)
    twice = TriangleMesh(wide.positions, wide.triangles, wide.normals, wide.uvs * 2)
    options = {"displacement": "height_map", "amplitude": 0.5, "height_map": smooth()}
    found = refine_mesh(device, twice, segments=128, **options).mesh
    row = np.flatnonzero(found.positions[:, 1] == 0.5)
    profile = heights(found)[row[np.argsort(found.positions[row, 0])]]
    assert np.abs(np.diff(profile)).max() < 0.5 * wide.diagonal * 0.25 * 2 * np.pi * 2 / 128


def test_bias_lowers_everything_and_a_negative_amplitude_turns_it_over(device):
    found = [
        heights(
            refine_mesh(
                device, plane(1), segments=8, displacement="height_map", height_map=VALUES, **options
            ).mesh
        )
        for options in ({"amplitude": 0.1}, {"amplitude": 0.1, "map_bias": 0.5}, {"amplitude": -0.1})
    ]  # fmt: skip
    np.testing.assert_allclose(found[1], found[0] - 0.05 * plane(1).diagonal, atol=ROUNDING32)
    np.testing.assert_array_equal(found[2], -found[0])


def test_normals_follow_the_raised_surface(device):
    options = {"displacement": "height_map", "amplitude": 0.05, "height_map": smooth(256)}
    found = made(device, plane(2), 64, **options).result()[0]
    a, b, c = found.positions.astype(float)[found.triangles].transpose(1, 0, 2)
    facet = np.cross(b - a, c - a)
    facet /= np.linalg.norm(facet, axis=1, keepdims=True)
    mean = found.normals.astype(float)[found.triangles].mean(axis=1)
    along = (facet * mean).sum(1) / np.linalg.norm(mean, axis=1)
    assert np.degrees(np.arccos(np.clip(along, -1, 1))).max() < 2


@pytest.mark.parametrize("scale", [1e-30, 1.0, 1e30])
def test_gradients_of_a_plane_are_those_of_its_map(scale):
    square = plane(3)
    turn = np.array([[1, 2, 2], [-2, -1, 2], [2, -2, 1]]) / 3
    points = (square.positions.astype(float) @ turn) * scale
    uvs = square.uvs @ [[2, 0.5], [-1, 3]]
    mesh = TriangleMesh(points.astype(np.float32), square.triangles, uvs=uvs)
    low, high = mesh.box
    expected = np.array([[2, -1, 0], [0.5, 3, 0]]) @ turn * ((high - low).max() / scale)
    found = uv_gradients(mesh)
    np.testing.assert_allclose(found, np.tile(expected, (len(found), 1, 1)), atol=1e-5)
    of_corners = uv_attributes(mesh, mesh.diagonal)
    assert of_corners.shape == (mesh.triangle_count, 3, 8)
    np.testing.assert_array_equal(of_corners[..., :2], mesh.uvs[mesh.triangles])
    per_diagonal = expected * mesh.diagonal / (high - low).max()
    np.testing.assert_allclose(of_corners[0, 0, 2:], per_diagonal.ravel(), atol=1e-5)


def test_meshes_without_area_are_finite(device):
    line = TriangleMesh(
        [[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], uvs=[[0, 0], [1, 5], [-3, 2]]
    )
    needle = TriangleMesh(
        [[0, 0, 0], [1, 0, 0], [1, 1e-30, 0]], [[0, 1, 2]], uvs=[[0, 0], [1e6, 5], [-3, 1e6]]
    )
    for mesh in (line, needle):
        for amplitude in (1.0, -1.0):
            prepared = made(
                device, mesh, 5, **HIGH | {"height_map": VALUES, "amplitude": amplitude}
            )
            found = prepared.result()[0]
            assert np.isfinite(found.positions).all() and np.isfinite(found.normals).all()
            assert prepared.check().passed


@pytest.mark.parametrize("segments", [1, 3, 16])
def test_per_triangle_gives_the_batched_bits(device, segments):
    mesh, options = with_uvs(shaken(icosphere(1))), {**HIGH, "height_map": VALUES}
    one, other = (
        made(device, mesh, segments, draw=draw, **options).result()[0] for draw in ("batched", "per_triangle")
    )  # fmt: skip
    assert np.array_equal(one.positions, other.positions)
    assert np.array_equal(one.normals, other.normals)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (HIGH, "height_map: expected a picture's path or an array, got none"),
        ({"height_map": "a.png"}, "displacement: expected 'height_map' where there is one, got 'sine'"),
        ({"height_map": VALUES}, "displacement: expected 'height_map' where there is one"),
        ({**HIGH, "height_map": VALUES}, "uvs: expected texture coordinates under a height map, got a mesh without"),
        ({**HIGH, "height_map": VALUES, "map_bias": 2}, "map_bias: expected 0 to 1, got 2"),
        ({**HIGH, "height_map": VALUES, "map_filter": "best"}, "map_filter: expected one of bilinear, nearest"),
    ],
)  # fmt: skip
def test_errors_name_the_argument(options, said):
    with pytest.raises(ValueError, match=said):
        refine(icosphere(0), **options)
