import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import GeometryImage, TriangleMesh
from lodbench.datasets_gen.triangles import icosphere
from lodbench.kernels import api, refine, refine_mesh, simplify, simplify_mesh
from lodbench.kernels.opencl.device import DeviceError

BALL = icosphere(2)
NONE = 0xFFFFFFFF


def image(origin=None):
    rows, columns = np.indices((9, 9)) / 8
    points = np.stack([rows, columns, rows * columns], axis=-1)
    if origin is not None:
        points = points + origin
    return GeometryImage(points, np.broadcast_to([0.0, 0.0, 1.0], (9, 9, 3)))


def test_open_device_is_taken_and_one_of_a_name_is_opened_once(device):
    assert api.open_device(device) is device
    assert api.open_device(None) is api.open_device(None)
    assert api.open_device("0:0") is api.open_device("0:0")
    assert api.open_device("0:0").facts.name


@pytest.mark.parametrize(
    ("given", "error", "text"),
    [
        (3, TypeError, "device: expected text or None, got 3"),
        ("no such", DeviceError, "got 'no such'"),
    ],
)
@pytest.mark.parametrize("call", [simplify_mesh, refine_mesh])
def test_device_that_is_none_is_refused_by_name(call, given, error, text):
    with pytest.raises(error, match=text):
        call(given, BALL, **({"cells": 3} if call is simplify_mesh else {}))


@pytest.mark.parametrize(
    ("came", "comes"),
    [
        ("float16", "float32"), ("float32", "float32"), ("float64", "float64"), ("int8", "float32"),
        ("int64", "float64"),
    ],
)  # fmt: skip
def test_points_come_back_in_the_narrowest_float_that_holds_what_came(device, came, comes):
    points = (BALL.positions * 50).astype(came)
    given = points.copy()
    for found, faces in (
        simplify(points, BALL.triangles, 0.5, device=device),
        refine(points, BALL.triangles, 2, device=device),
    ):
        assert found.dtype == comes and found.shape[1] == 3
        assert faces.dtype == np.uint32 and faces.max() < len(found)
    np.testing.assert_array_equal(points, given)


def test_third_argument_is_the_share_removed(device):
    by_place = simplify(BALL.positions, BALL.triangles, 0.75, device=device)
    by_name = simplify(BALL, target_reduction=0.75, device=device)
    assert len(by_place[1]) <= 0.25 * BALL.triangle_count
    for one, other in zip(by_place, by_name, strict=True):
        np.testing.assert_array_equal(one, other)


def test_arrays_are_those_of_the_mesh_that_the_longer_call_gives(device):
    far = TriangleMesh(BALL.positions.astype(float) + 1e6, BALL.triangles)
    short = simplify(far, cells=5, device=device), refine(far, segments=3, device=device)
    full = simplify_mesh(device, far, cells=5), refine_mesh(device, far, segments=3)
    for (points, faces), result in zip(short, full, strict=True):
        np.testing.assert_array_equal(points, result.mesh.points)
        np.testing.assert_array_equal(faces, result.mesh.triangles)
        np.testing.assert_array_equal(result.mesh.origin, far.origin)
        assert all(np.array_equal(level.origin, far.origin) for level in result.levels)


def test_mesh_without_an_origin_keeps_none(device):
    assert BALL.origin is None
    for result in (simplify_mesh(device, BALL, cells=5), refine_mesh(device, BALL)):
        assert result.mesh.origin is None


def test_vertex_map_names_the_vertex_that_stands_for_each(device):
    result = simplify_mesh(device, BALL, cells=4)
    found = result.vertex_map
    assert found is not None and found.shape == (BALL.vertex_count,)
    kept = found != NONE
    assert set(found[kept]) == set(range(result.mesh.vertex_count)), "no vertex without a triangle"
    apart = BALL.positions[kept] - result.mesh.positions[found[kept]]
    edge = np.ptp(BALL.positions, axis=0).max() / 4
    assert np.abs(apart).max() <= 2 * edge


def test_refined_triangles_share_their_edges_unless_they_are_to_keep_their_own(device):
    segments = 3
    each = (segments + 1) * (segments + 2) // 2
    welded, faces = refine(BALL, segments=segments, device=device)
    own, own_faces = refine(BALL, segments=segments, weld=False, device=device)
    assert len(faces) == len(own_faces) == segments**2 * BALL.triangle_count
    assert len(own) == each * BALL.triangle_count
    assert len(welded) == len(faces) // 2 + 2, "a closed surface of genus 0"


@pytest.mark.parametrize("origin", [None, (1e6, 0, 0)])
def test_geometry_image_is_simplified_in_the_float_that_its_origin_needs(device, origin):
    points, faces = simplify(image(origin), target_count=40, device=device)
    assert points.dtype == (np.float32 if origin is None else np.float64)
    assert 0 < len(faces) <= 128
    assert np.abs(points - np.array(origin or (0, 0, 0))).max() <= 1.001


def test_geometry_image_cannot_be_refined(device):
    with pytest.raises(TypeError, match=r"points: expected a mesh, .*, got GeometryImage"):
        refine(image(), device=device)


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: simplify(BALL, cells=3, method="pattern"), "method: expected one of .*'pattern'"),
        (
            lambda: refine(BALL, method="vertex_average"),
            "method: expected one of adaptive_patterns, pattern, ",
        ),
        (lambda: simplify(BALL, 0.5), "points: expected .n, 3. float32, got shape"),
        (
            lambda: simplify(BALL.positions, BALL.triangles + 1, 0.5),
            "faces: expected indices from 0 to 161",
        ),
        (lambda: simplify(np.full((3, 3), np.nan), [(0, 1, 2)], 0.5), "NaN|finite"),
    ],
)
def test_wrong_call_is_refused_before_a_device_is_opened(monkeypatch, call, text):
    monkeypatch.setattr(api, "open_device", lambda device: pytest.fail("a device was opened"))
    with pytest.raises((ValueError, TypeError), match=text):
        call()
