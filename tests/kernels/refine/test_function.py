import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, plane, torus
from lodbench.kernels import refine, refine_mesh
from lodbench.kernels.refine import pattern, pn_triangles, st_triangles
from lodbench.kernels.refine.function_text import check_function
from lodbench.kernels.system import Frame, run
from tests.kernels.refine.test_pattern import shaken, tetrahedron
from tests.tolerances import DIFFERENCES, ROUNDING32

HEAD = "float displace(float3 position, float3 normal, float2 uv, float time)"
SYSTEMS = pytest.mark.parametrize("system", [pattern, pn_triangles, st_triangles])


def function(body):
    return {"displacement": "function", "function": f"{HEAD}\n{{\n    {body}\n}}\n"}


BUMPS = function(
    "return 0.05f * sin(7 * position.x + 3 * time) * cos(5 * position.y + position.z);"
)
OF_UV = function("return 0.04f * sin(6 * uv.x + 1) * cos(5 * uv.y + time);")
ANY = function("return 0.02f * sin(9 * position.z + 4 * uv.x) + 0.01f * normal.x * cos(8 * uv.y);")


def with_uvs(mesh, seed=0):
    """Any uvs at all: what is shared has the same ones."""
    uvs = np.random.default_rng(seed).normal(size=(mesh.vertex_count, 2))
    return TriangleMesh(mesh.positions, mesh.triangles, mesh.normals, uvs)


def made(device, mesh, segments, system=pattern, frame=None, **options):
    prepared = system.SYSTEM.prepare(device, mesh, system.Params(segments, **options))
    run(device, prepared, frame or Frame())
    return prepared


def distinct(mesh):
    """Vertices that differ in points or normals, to the bit but for the sign of zeros."""
    return len(np.unique(np.hstack([mesh.positions, mesh.normals]) + np.float32(0), axis=0))


@SYSTEMS
@pytest.mark.parametrize("options", [BUMPS, OF_UV, ANY], ids=["bumps", "of uv", "any"])
@pytest.mark.parametrize("segments", [1, 3, 8, 33])
@pytest.mark.parametrize("make", [tetrahedron, lambda: shaken(icosphere(1)), lambda: torus(9, 7)])
def test_surface_agrees_with_the_function(device, system, make, segments, options):
    for mesh in (make(), with_uvs(make())):
        check = made(device, mesh, segments, system, Frame(time=0.3), **options).check()
        assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"
        assert "the function's own" in check.what


def test_check_sees_a_surface_that_is_not_the_function_s(device):
    for name in ("_positions", "_normals"):
        spoilt = made(device, with_uvs(icosphere(1)), 8, **ANY)
        assert spoilt.check().passed
        values = device.read(getattr(spoilt, name))
        values[1:] = values[:-1]
        device.cl.enqueue_copy(device.queue, getattr(spoilt, name).memory, values)
        assert not spoilt.check().passed


@pytest.mark.parametrize(
    "body", ["step(0.1f, position.x)", "floor(8 * uv.x) * 0.01f", "normal.z < 0 ? 0.1f : 0"]
)
def test_check_leaves_out_jumps(device, body):  # fmt: skip
    check = made(device, with_uvs(icosphere(1)), 16, **function(f"return {body};")).check()
    assert check.passed, f"{check.value} > {check.tolerance}"


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    seed=st.integers(0, 2**31), segments=st.integers(1, 17), options=st.sampled_from([BUMPS, OF_UV, ANY]),
    system=st.sampled_from([pattern, pn_triangles]), mapped=st.booleans(), offset=st.sampled_from([0, 100]),
)  # fmt: skip
def test_closed_mesh_has_no_cracks(device, seed, segments, options, system, mapped, offset):
    mesh = shaken(icosphere(1), seed, offset)
    mesh = with_uvs(mesh, seed) if mapped else mesh
    if not mapped and options is OF_UV:
        return  # moves every point alike
    found = made(device, mesh, segments, system, Frame(time=0.7), **options).result()[0]
    assert distinct(found) == mesh.triangle_count * segments**2 // 2 + 2


def test_normals_with_zeros_of_either_sign_have_no_cracks(device):
    # a box about the origin, with the normals of its axes: coordinates and normals full of zeros
    mesh = icosphere(0)
    points = np.round(mesh.positions * 2) / 2
    flat = TriangleMesh(points, mesh.triangles, np.where(np.abs(points) == 1, points, -0.0))
    found = made(device, flat, 8, **function("return 0.1f * atan2(position.y, position.x);"))
    welded, apart = found.welded(), found.result()[0]
    assert (welded.positions[welded.triangles] == apart.positions[apart.triangles]).all()
    assert (welded.normals[welded.triangles] == apart.normals[apart.triangles]).all()


def test_seams_open(device):
    """Where uvs differ on the two sides of an edge the function may say two things."""
    square = plane(1)
    points, normals = square.positions[square.triangles], square.normals[square.triangles]
    apart = TriangleMesh(
        points.reshape(-1, 3), np.arange(6).reshape(2, 3), normals.reshape(-1, 3),
        np.repeat([[0, 0], [0.5, 0.5]], 3, axis=0),
    )  # fmt: skip
    closed, opened = (
        made(device, apart, 4, **function(f"return 0.1f + {body};")).result()[0]
        for body in ("position.x", "uv.x")
    )
    assert len(np.unique(closed.positions, axis=0)) == 5 * 5
    assert len(np.unique(opened.positions, axis=0)) == 5 * 5 + 5


def test_position_normal_uv_and_time_are_what_they_are_called(device):
    mesh = plane(1)
    moved = TriangleMesh(mesh.positions * 4 + 1, mesh.triangles, mesh.normals, mesh.uvs)
    for body, expected in {
        "position.x + 10 * position.y": lambda p: p[:, 0] + 10 * p[:, 1],
        "position.z": lambda p: 1,
        "3 * normal.z + normal.x": lambda p: 3,
        "uv.x + 10 * uv.y": lambda p: ((p - 1) / 4) @ (1, 10, 0),
        "time": lambda p: 2.5,
        "0.25f": lambda p: 0.25,
    }.items():
        found = refine_mesh(device, moved, segments=8, time=2.5, **function(f"return {body};")).mesh
        points = found.positions.astype(float)
        heights = points[:, 2] - 1
        np.testing.assert_allclose(heights, expected(points) + 0 * heights, atol=60 * ROUNDING32)


def test_uv_is_zero_where_the_mesh_has_none(device):
    found = refine_mesh(device, icosphere(1), segments=4, **function("return uv.x + uv.y;")).mesh
    flat = refine_mesh(device, icosphere(1), segments=4).mesh
    assert np.array_equal(found.positions, flat.positions)


@pytest.mark.parametrize("scale", [1e-20, 1.0, 1e20])
@pytest.mark.parametrize(
    "body", ["0.3f * position.x - 0.2f * position.y", "uv.x * SIZE * 0.3f - uv.y * SIZE * 0.2f"]
)
def test_normal_of_a_slope_is_exact(device, body, scale):  # fmt: skip
    square = plane(3)
    mesh = TriangleMesh(
        square.positions.astype(float) * scale, square.triangles, square.normals, square.uvs
    )
    text = function(f"return {body.replace('SIZE', f'{scale}f')};")
    normals = made(device, mesh, 5, **text).result()[0].normals
    expected = np.array([-0.3, 0.2, 1]) / np.linalg.norm([0.3, 0.2, 1])
    np.testing.assert_allclose(normals, np.tile(expected, (len(normals), 1)), atol=DIFFERENCES)


def test_normals_follow_the_raised_surface(device):
    bumps = function(
        "return 0.02f * sin(9 * position.x) * sin(8 * position.y) * sin(7 * position.z);"
    )
    found = made(device, icosphere(2), 24, pn_triangles, **bumps).result()[0]
    a, b, c = found.positions.astype(float)[found.triangles].transpose(1, 0, 2)
    facet = np.cross(b - a, c - a)
    facet /= np.linalg.norm(facet, axis=1, keepdims=True)
    mean = found.normals.astype(float)[found.triangles].mean(axis=1)
    along = (facet * mean).sum(1) / np.linalg.norm(mean, axis=1)
    assert np.degrees(np.arccos(np.clip(along, -1, 1))).max() < 4


def test_time_animates(device):
    prepared = made(device, icosphere(1), 6, **BUMPS)
    still = prepared.result()[0].positions
    run(device, prepared, Frame(time=0.5))
    assert (prepared.result()[0].positions != still).any()
    run(device, prepared, Frame())
    assert np.array_equal(prepared.result()[0].positions, still)


def test_time_beyond_the_device_s_floats_is_its_largest(device):
    late = function("return time > 3e38f && time < INFINITY ? 0.5f : 0;")
    prepared = made(device, plane(1), 1, frame=Frame(time=1e300), **late)
    assert (prepared.result()[0].positions[:, 2] == 0.5).all()


@pytest.mark.parametrize("segments", [1, 3, 16])
def test_per_triangle_gives_the_batched_bits(device, segments):
    mesh = with_uvs(shaken(icosphere(1)))
    one, other = (
        made(device, mesh, segments, draw=draw, **ANY).result()[0] for draw in ("batched", "per_triangle")
    )  # fmt: skip
    assert np.array_equal(one.positions, other.positions)
    assert np.array_equal(one.normals, other.normals)


def test_levels_nest_to_the_bit(device):
    mesh = with_uvs(shaken(icosphere(1)))
    fine, coarse = (made(device, mesh, n, **ANY).welded() for n in (16, 4))
    within = {row.tobytes() for row in np.hstack([fine.positions, fine.normals])}
    assert {row.tobytes() for row in np.hstack([coarse.positions, coarse.normals])} <= within


@pytest.mark.parametrize("body", ["log(-1.0f)", "1.0f / (position.x - position.x)", "1e38f * 10"])
def test_heights_that_are_not_finite_are_refused(device, body):
    with pytest.raises(
        ValueError, match="function: expected finite heights, got infinity or NaN at "
    ):
        refine(icosphere(0), segments=2, **function(f"return {body};"))


def test_normals_stay_where_there_is_no_slope(device):
    # finite on the plane alone, so that no difference is
    line = TriangleMesh(
        [[0, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2]], np.tile([1.0, 0, 0], (3, 1))
    )
    found = made(device, line, 3, **function("return position.x == 0 ? 0.5f : NAN;")).result()[0]
    assert (found.positions[:, 0] == 0.5).all()
    assert (found.normals == (1, 0, 0)).all()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"displacement": "function"}, "function: expected float displace.*, got no text"),
        ({"displacement": "function", "function": "float f(float x) { return x; }"}, "got none"),
        ({"function": BUMPS["function"]}, "displacement: expected 'function' where there is one, got 'sine'"),
        ({**BUMPS, "amplitude": 0.1}, "amplitude: expected 0 for a function, which gives model units, got 0.1"),
        (function("\n return foo;"), "function: expected OpenCL C that builds, line 4: .*'foo'"),
        (
            {"displacement": "function", "function": "float displace(float3 p) { return 1; }"},
            r"function: expected float displace\(float3 position, .*\), got another: too many arguments",
        ),
    ],
)  # fmt: skip
def test_errors_name_the_argument(options, said):
    with pytest.raises(ValueError, match=said):
        refine(icosphere(0), **options)


def test_uvs_without_digits_are_refused():
    mesh = icosphere(0)
    far = TriangleMesh(mesh.positions, mesh.triangles, uvs=np.full((mesh.vertex_count, 2), 1e7))
    with pytest.raises(ValueError, match=r"uvs: expected coordinates up to 1e\+06, got 1e\+07"):
        refine(far, **BUMPS)


@pytest.mark.parametrize(
    "text",
    [
        f"{HEAD} {{ return displace(position, normal, uv, time); }}",
        f"float a(int x); float b(int x){{ return a(x); }} float a(int y) {{ return b(y); }} {HEAD} {{ return a(1); }}",
    ],
)
def test_recursion_is_refused(text):
    with pytest.raises(ValueError, match="function: expected no recursion, got "):
        check_function(text)


@pytest.mark.parametrize(
    "text",
    [
        f"{HEAD};\n{HEAD} {{ return 1; }}",
        f"// displace(1)\n{HEAD} {{ /* displace(x) }} */ if (time > 1) {{ return 2; }} return 1; }}",
        f"float own(float x) {{ for (;;) {{ return x; }} }}\nstatic inline {HEAD} {{ return own(own(1)); }}",
    ],
)
def test_text_that_only_looks_like_recursion_is_taken(text):
    assert check_function(text) == text


@pytest.mark.parametrize("text", [f"{HEAD} {{ return 1; }}\0", f"{HEAD} {{ return 1; }} // \ud800"])
def test_what_is_no_text_is_refused(text):
    with pytest.raises(ValueError, match="function: expected OpenCL C, got characters"):
        check_function(text)
