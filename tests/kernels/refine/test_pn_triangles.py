import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, plane, torus
from lodbench.kernels import Device, refine
from lodbench.kernels.refine import pattern
from lodbench.kernels.refine.lattice import lattice_weights
from lodbench.kernels.refine.pn_triangles import Params, PnTriangles
from lodbench.kernels.refine.pn_triangles.reference import (
    control_normals,
    control_points,
    curved,
)
from lodbench.kernels.system import Frame, run
from tests.kernels.refine.test_pattern import shaken, tetrahedron
from tests.tolerances import ROUNDING32, UNIT_LENGTH

SINE = {"amplitude": 0.03, "waves": 5.0}
MODES = pytest.mark.parametrize(
    "mode", [{}, {"shading_normals": "linear"}, SINE], ids=["quadratic", "linear", "sine"]
)


def draw(device, mesh, segments, **params):
    prepared = PnTriangles(device, mesh, Params(segments, **params))
    run(device, prepared, Frame(time=0.7))
    return prepared


def corners(mesh):
    return mesh.positions[mesh.triangles].astype(float), mesh.normals[mesh.triangles].astype(float)


@MODES
@pytest.mark.parametrize("segments", [1, 2, 3, 7, 16, 33])
@pytest.mark.parametrize(
    "make", [tetrahedron, lambda: plane(2), lambda: shaken(icosphere(1)), lambda: torus(9, 7)]
)
def test_pn_triangles_agree_with_reference(device, make, segments, mode):
    check = draw(device, make(), segments, **mode).check()
    assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"


@MODES
@pytest.mark.parametrize("segments", [1, 2, 3, 5, 16, 30])
@pytest.mark.parametrize(
    "make",
    [tetrahedron, lambda: shaken(icosphere(2)), lambda: shaken(icosphere(1), offset=1000.0)],
    ids=["tetrahedron", "ball", "far ball"],
)
def test_pn_triangles_leave_no_cracks(device, make, segments, mode):
    mesh = make()
    refined = draw(device, mesh, segments, **mode).result()[0]
    # V = T n^2 / 2 + 2 on a closed surface of genus 0, when points that should be one are, to the bit
    expected = mesh.triangle_count * segments**2 // 2 + 2
    both = np.hstack([refined.positions, refined.normals]) + np.float32(0)
    assert len(np.unique(both[:, :3], axis=0)) == expected
    assert len(np.unique(both, axis=0)) == expected


@settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(seed=st.integers(0, 2**32 - 1), segments=st.integers(1, 9), split=st.booleans())
def test_random_normals_leave_closed_meshes_closed(device, seed, segments, split):
    random = np.random.default_rng(seed)
    mesh = shaken(icosphere(1), seed % 1000)
    normals = random.normal(size=(mesh.vertex_count, 3))
    normals[random.random(len(normals)) < 0.1] = 0  # no direction
    mesh = TriangleMesh(mesh.positions, mesh.triangles, normals)
    made = draw(device, mesh, segments, **({} if split else SINE))
    assert made.check().passed
    points = made.result()[0].positions + np.float32(0)
    assert len(np.unique(points, axis=0)) == mesh.triangle_count * segments**2 // 2 + 2


def test_split_normals_open_a_crease_between_their_edges(device):
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.5]]
    sharp = TriangleMesh(
        [*points[:3], points[1], points[3], points[2]], [[0, 1, 2], [3, 4, 5]],
        [[0, 0, 1]] * 3 + [[-0.6, 0, 0.8], [0, 0, 1], [0, 0, 1]],
    )  # fmt: skip
    smooth = TriangleMesh(points, [[0, 1, 2], [1, 3, 2]], [[0, 0, 1]] * 4)
    counts = [
        len(np.unique(draw(device, mesh, 4).result()[0].positions + np.float32(0), axis=0))
        for mesh in (smooth, sharp)
    ]
    assert counts == [25, 28], (
        "five points on the edge: its ends are one, the three between are not"
    )


@pytest.mark.parametrize("segments", [1, 4, 13])
def test_corners_are_the_coarse_points_to_the_bit(device, segments):
    mesh = shaken(icosphere(1))
    welded = draw(device, mesh, segments).welded()
    assert np.array_equal(welded.positions[: mesh.vertex_count], mesh.positions)


def test_flat_triangles_with_their_own_normals_stay_flat(device):
    mesh = plane(3)
    curved_mesh = draw(device, mesh, 8).result()[0]
    flat_mesh = pattern.Pattern(device, mesh, pattern.Params(8)).result()[0]
    np.testing.assert_allclose(curved_mesh.positions, flat_mesh.positions, atol=ROUNDING32)
    np.testing.assert_allclose(curved_mesh.normals, flat_mesh.normals, atol=UNIT_LENGTH)


def test_tangent_planes_at_corners_are_those_of_the_normals():
    P, N = corners(shaken(icosphere(1)).with_normals())
    N /= np.linalg.norm(N, axis=-1, keepdims=True)
    b = control_points(P, N)
    for corner, handles in enumerate((("b210", "b201"), ("b120", "b021"), ("b102", "b012"))):
        for handle in handles:
            assert np.abs(((b[handle] - P[:, corner]) * N[:, corner]).sum(-1)).max() < 1e-15


def test_an_edge_curve_depends_on_its_ends_alone():
    P, N = corners(icosphere(1))
    turned = np.roll(P, -1, axis=1), np.roll(N, -1, axis=1)
    one, other = control_points(P, N), control_points(*turned)
    assert np.array_equal(one["b021"], other["b210"]) and np.array_equal(one["b012"], other["b120"])
    assert np.allclose(control_normals(P, N)["n011"], control_normals(*turned)["n110"])


def test_cubic_reproduces_a_quadratic_surface():
    """b111 is set so that six edge points of a quadratic give the quadratic back."""
    corner_points = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]], float)
    b = control_points(corner_points, np.tile([0.0, 0.0, 1.0], (1, 3, 1)))
    # degree elevation of z = u v: b111 of 3 points on two edges' ends, 1/6
    z = {"b210": 0, "b120": 0, "b201": 0, "b102": 0, "b021": 1 / 3, "b012": 1 / 3}
    E, V = sum(z.values()) / 6, 0.0
    assert E + (E - V) / 2 == pytest.approx(1 / 6)
    assert np.allclose(b["b111"], corner_points.mean(axis=1))


@pytest.mark.parametrize(
    ("level", "least", "flat_least", "degrees"),
    [(0, 0.94158, 0.7956, 3.20), (1, 0.9936, 0.9340, 2.5), (2, 0.9995, 0.9828, 1.3)],
)
def test_sphere_of_exact_normals_is_nearly_round(device, level, least, flat_least, degrees):
    mesh = icosphere(level)
    made = draw(device, mesh, 16).result()[0]
    radius = np.linalg.norm(made.positions.astype(float), axis=1)
    assert least - 1e-4 < radius.min() and radius.max() < 1 + 1e-6
    flat_mesh = pattern.Pattern(device, mesh, pattern.Params(16)).result()[0]
    assert np.linalg.norm(flat_mesh.positions, axis=1).min() == pytest.approx(flat_least, abs=1e-2)
    off = (made.normals * made.positions / radius[:, None]).sum(1)
    assert np.degrees(np.arccos(np.clip(off, -1, 1))).max() < degrees + 0.02


def test_moving_turning_and_scaling_the_input_does_the_same_to_the_output(device):
    mesh = shaken(icosphere(1)).with_normals()
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    moved = TriangleMesh(mesh.positions @ turn.T * 4 + 0.5, mesh.triangles, mesh.normals @ turn.T)
    one, other = (draw(device, m, 6).result()[0] for m in (mesh, moved))
    expected = one.positions.astype(float) @ turn.T * 4 + 0.5
    np.testing.assert_allclose(other.positions, expected, atol=16 * ROUNDING32)
    np.testing.assert_allclose(other.normals, one.normals @ turn.T, atol=16 * ROUNDING32)


@pytest.mark.parametrize("exponent", [-100, -60, 60, 110])
def test_powers_of_two_scale_the_result_exactly(device, exponent):
    points = np.round(icosphere(1).positions.astype(float) * 1024)
    one, other = (
        draw(device, TriangleMesh(points * 2.0**k, icosphere(1).triangles), 4).result()[0]
        for k in (-10, exponent - 10)
    )
    np.testing.assert_array_equal(other.normals, one.normals)
    expected = one.positions.astype(float) * 2.0**exponent
    np.testing.assert_allclose(other.positions, expected, rtol=0, atol=2.0**-140)


def test_triangles_without_area_or_normals_are_finite(device):
    points = [[0, 0, 0], [0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]]
    faces = [[0, 1, 2], [0, 2, 3], [4, 4, 4], [0, 2, 4]]
    for normals in (
        None,
        np.zeros((5, 3)),
        [[0, 0, 1], [0, 0, -1], [1, 0, 0], [-1, 0, 0], [0, 0, 1]],
    ):
        made = draw(device, TriangleMesh(points, faces, normals), 5).result()[0]
        assert np.isfinite(made.positions).all()
        assert np.abs(np.linalg.norm(made.normals, axis=1) - 1).max() < UNIT_LENGTH


def test_coordinates_beyond_what_control_points_hold_are_refused(device):
    mesh = TriangleMesh(np.array([[3e37, 0, 0], [0, 1, 0], [0, 0, 1]], np.float32), [[0, 1, 2]])
    with pytest.raises(ValueError, match=r"points: expected coordinates up to 1e\+37, got 3e\+37"):
        draw(device, mesh, 2)


def test_reference_weights_sum_to_one_and_corners_interpolate():
    P, N = corners(icosphere(1))
    shifted = curved(P + 5, N, lattice_weights(6))[0]
    np.testing.assert_allclose(shifted, curved(P, N, lattice_weights(6))[0] + 5, atol=1e-13)
    points, normals = curved(P, N, np.eye(3))
    np.testing.assert_array_equal(points, P)
    np.testing.assert_array_equal(normals, N)


def test_method_is_reached_by_its_name():
    points, faces = refine(icosphere(1), segments=4, method="pn_triangles")
    assert len(faces) == 80 * 16
    assert np.linalg.norm(points, axis=1).min() > 0.993


def test_what_does_not_fit_at_once_is_refined_in_batches():
    mesh, segments = icosphere(2), 32
    whole = PnTriangles(Device.open(), mesh, Params(segments)).result()[0]
    small = Device.open(memory_limit=2_000_000)
    parts = PnTriangles(small, mesh, Params(segments))
    assert parts.footprint().batches > 1 and not parts.output
    assert np.array_equal(parts.result()[0].positions, whole.positions)
    assert parts.check().passed
