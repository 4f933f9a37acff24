import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, plane, torus
from lodbench.kernels.opencl.device import Device, Unsupported
from lodbench.kernels.opencl.timeline import Timeline
from lodbench.kernels.refine.displacement import Wave
from lodbench.kernels.refine.lattice import lattice_vertex_count, lattice_weights
from lodbench.kernels.refine.pattern import Params, refine
from lodbench.kernels.refine.pattern.host import Pattern
from lodbench.kernels.refine.pattern.reference import flat
from lodbench.kernels.refine.reference import largest_error, refined
from lodbench.kernels.stages.camera import look_at
from lodbench.kernels.stages.raster import Raster
from lodbench.kernels.system import Frame, View, run
from tests.tolerances import ROUNDING32, UNIT_LENGTH

TRIANGLE = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
STILL = Frame()
EMPTY = TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int))
SINE = {"amplitude": 0.03, "waves": 5.0}
MODES = pytest.mark.parametrize("mode", [{}, SINE], ids=["flat", "sine"])


def tetrahedron():
    points = [[1, 1, 1], [-1, -1, 1], [-1, 1, -1], [1, -1, -1]]
    return TriangleMesh(points, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])


def shaken(mesh, seed=0, offset=0.0):
    """No two coordinates alike, so that nothing agrees by chance."""
    random = np.random.default_rng(seed)
    return TriangleMesh(
        mesh.positions * (1 + 0.1 * random.random((mesh.vertex_count, 3))) + offset,
        mesh.triangles[random.permutation(mesh.triangle_count)],
    )


def draw(device, mesh, segments, frame=STILL, **params):
    prepared = Pattern(device, mesh, Params(segments, **params))
    run(device, prepared, frame)
    return prepared


def as_bytes(mesh):
    return mesh.positions.tobytes(), mesh.normals.tobytes(), mesh.triangles.tobytes()


def seen_from(distance):
    """A camera on the x axis, `distance` from the unit ball's box."""
    return Frame(View(np.array([1 + distance, 0.0, 0.0]), np.eye(4), 64, 64))


@MODES
@pytest.mark.parametrize("segments", [1, 2, 3, 4, 7, 16, 33])
@pytest.mark.parametrize(
    "make", [lambda: TRIANGLE, tetrahedron, lambda: plane(2), lambda: shaken(icosphere(1))]
)
def test_pattern_agrees_with_reference(device, make, segments, mode):
    check = draw(device, make(), segments, Frame(time=0.3), **mode).check()
    assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"


@MODES
@pytest.mark.parametrize("segments", [1, 2, 3, 5, 16, 30])
@pytest.mark.parametrize(
    "make",
    [tetrahedron, lambda: shaken(icosphere(2)), lambda: shaken(icosphere(1), offset=1000.0)],
    ids=["tetrahedron", "ball", "far ball"],
)
def test_pattern_leaves_no_cracks(device, make, segments, mode):
    mesh = make()
    prepared = draw(device, mesh, segments, Frame(time=0.7), **mode)
    vertices = np.hstack([(m := prepared.result()[0]).positions, m.normals])
    # V = T n^2 / 2 + 2 on a closed surface of genus 0, when points and normals that should be one are, to the bit
    expected = mesh.triangle_count * segments**2 // 2 + 2
    assert len(np.unique(vertices.view(np.uint32), axis=0)) == expected
    assert len(np.unique(vertices[:, :3].copy().view(np.uint32), axis=0)) == expected


@MODES
def test_pattern_welded_is_closed_and_equal(device, mode):
    mesh = shaken(torus(9, 7))
    prepared = draw(device, mesh, 6, **mode)
    apart, welded = prepared.result()[0], prepared.welded()
    assert welded.vertex_count == mesh.triangle_count * 36 // 2  # Euler characteristic 0
    assert np.array_equal(welded.positions[welded.triangles], apart.positions[apart.triangles])
    assert np.array_equal(welded.normals[welded.triangles], apart.normals[apart.triangles])
    edges = welded.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    forward = {(a, b) for a, b in edges.tolist()}
    assert len(forward) == len(edges)
    assert all((b, a) in forward for a, b in forward)


def test_pattern_keeps_coarse_points_and_area(device):
    mesh = shaken(icosphere(1))
    flat = draw(device, mesh, 8).welded()
    assert np.array_equal(flat.positions[: mesh.vertex_count], mesh.positions)

    def area(m):
        a, b, c = m.positions.astype(float)[m.triangles].transpose(1, 0, 2)
        return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2

    assert area(flat) == pytest.approx(area(mesh), rel=ROUNDING32)


@MODES
@pytest.mark.parametrize("exponent", [-100, -60, 60, 120])
def test_pattern_powers_of_two_scale_the_result_exactly(device, mode, exponent):
    points = np.round(icosphere(1).positions.astype(float) * 1024)
    one, other = (
        draw(device, TriangleMesh(points * 2.0**k, icosphere(1).triangles), 4, **mode).result()[0]
        for k in (-10, exponent - 10)
    )
    np.testing.assert_array_equal(other.normals, one.normals)
    # a height next to nothing loses digits to the smallest float, and only there
    expected = one.positions.astype(float) * 2.0**exponent
    np.testing.assert_allclose(other.positions, expected, rtol=0, atol=2.0**-148)


@pytest.mark.parametrize("amplitude", [0.0, 0.1, -1.0])
@pytest.mark.parametrize(
    "points",
    [
        [[1, 2, 3]] * 3,
        [[1e38, 1e38, -1e38]] * 3,
        [[1, 0, 0], [1, 1e-20, 0], [1, 0, 1e-20]],
        [[1e38, 1e-38, 1], [-1e38, 0, 1e-45], [0, 1e38, 0]],
        [[1e38, -1e38, 1e38], [-1e38, 1e38, 1e38], [0, 0, -1e38]],
    ],
)
def test_pattern_of_any_floats_is_finite(device, points, amplitude):
    mesh = TriangleMesh(np.array(points, np.float32), [[0, 1, 2]])  # as they are, about no origin
    prepared = draw(device, mesh, 5, amplitude=amplitude)
    assert np.isfinite(prepared.result()[0].positions).all()
    assert prepared.check().passed


@MODES
def test_pattern_normals_are_units(device, mode):
    normals = draw(device, shaken(icosphere(2)), 9, **mode).result()[0].normals
    assert np.abs(np.linalg.norm(normals.astype(float), axis=1) - 1).max() < UNIT_LENGTH


def test_pattern_sine_normal_is_that_of_the_surface(device):
    # a plane with its own normals: the raised surface's normal is the chain rule's, checked by finite differences
    mesh = TriangleMesh([[1, 0, 0.5], [3, 0, 0.5], [1, 2, 0.5]], [[0, 1, 2]])
    made = draw(device, mesh, 256, amplitude=0.02, waves=3.0).result()[0]
    a, b, c = made.positions.astype(float)[made.triangles].transpose(1, 0, 2)
    face = np.cross(b - a, c - a)
    face /= np.linalg.norm(face, axis=1, keepdims=True)
    of_corners = made.normals[made.triangles].mean(axis=1)
    assert np.abs(made.positions[:, 2] - 0.5).max() > 0.9 * 0.02 * mesh.diagonal
    # within a step the normal turns by about a f^2 / n of a radian
    assert np.linalg.norm(face - of_corners, axis=1).max() < 0.02


def test_pattern_wave_passes_once_a_second(device):
    mesh = icosphere(1)
    at = [as_bytes(draw(device, mesh, 4, Frame(time=t), **SINE).result()[0]) for t in (0, 0.25, 1)]
    assert at[0] == at[2]
    assert at[0] != at[1]


def test_pattern_nests_to_the_bit(device):
    mesh = shaken(icosphere(1))
    fine = draw(device, mesh, 16, **SINE).welded()
    coarse = draw(device, mesh, 4, **SINE).welded()
    within = {row.tobytes() for row in np.hstack([fine.positions, fine.normals])}
    assert {row.tobytes() for row in np.hstack([coarse.positions, coarse.normals])} <= within


@MODES
@pytest.mark.parametrize("segments", [1, 3, 16, 64])
def test_pattern_per_triangle_gives_the_batched_bits(device, segments, mode):
    mesh = shaken(icosphere(1))
    batched = draw(device, mesh, segments, **mode)
    single = draw(device, mesh, segments, draw="per_triangle", **mode)
    assert as_bytes(single.result()[0]) == as_bytes(batched.result()[0])
    assert single.counters()["launches"] == mesh.triangle_count


@pytest.mark.parametrize("count", [1, 63, 64, 65, 129])
def test_pattern_sizes_around_a_work_group(device, count):
    # segments 1: three vertices each, so that vectors, chunks and groups all begin inside a triangle somewhere
    mesh = shaken(plane(12))
    part = TriangleMesh(mesh.positions, mesh.triangles[:count])
    for segments in (1, 10):
        prepared = draw(device, part, segments)
        assert prepared.check().passed
        assert prepared.counters()["vertices"] == count * lattice_vertex_count(segments)


@MODES
def test_pattern_does_not_depend_on_the_work_group(device, mode):
    mesh = shaken(icosphere(1))
    expected = as_bytes(draw(device, mesh, 7, **mode).result()[0])
    for options in ({"local_size": 1}, {"local_size": 13}, {"one_core": True}):
        other = Device.open(**options)
        assert as_bytes(draw(other, mesh, 7, **mode).result()[0]) == expected


@pytest.mark.parametrize("way", ["batched", "per_triangle"])
def test_pattern_works_in_batches_where_memory_is_short(device, way):
    mesh, segments = shaken(icosphere(1)), 16
    whole = draw(device, mesh, segments, **SINE)
    small = Device.open(memory_limit=100_000)
    parts = draw(small, mesh, segments, draw=way, **SINE)
    footprint = parts.footprint()
    assert footprint.batches > 1
    assert not parts.output  # no buffer holds the whole surface
    assert footprint.output_bytes + footprint.pattern_bytes + footprint.input_bytes <= 100_000
    assert parts.check().passed
    assert as_bytes(parts.result()[0]) == as_bytes(whole.result()[0])
    assert as_bytes(parts.welded()) == as_bytes(whole.welded())


def test_pattern_says_what_memory_it_needs():
    with pytest.raises(Unsupported, match=r"needs .* bytes of device memory, device has"):
        Pattern(Device.open(memory_limit=10_000), TRIANGLE, Params(64))


def test_pattern_streams_large_outputs_to_the_same_bits(device):
    # more than the 16 MiB that stay in caches, ending within a vector
    mesh = shaken(plane(19, 15))
    large = draw(device, mesh, 61)
    assert large.footprint().output_bytes > 16 << 20
    assert large.check().passed
    few = TriangleMesh(mesh.positions, mesh.triangles[:3], mesh.with_normals().normals)
    small, vertices = draw(device, few, 61).result()[0], 3 * lattice_vertex_count(61)
    assert np.array_equal(large.result()[0].positions[:vertices], small.positions)
    assert np.array_equal(large.result()[0].normals[:vertices], small.normals)


def test_pattern_chooses_its_level_by_distance(device):
    mesh = icosphere(1)
    prepared = Pattern(device, mesh, Params(16, levels=4, near=1.0))
    diagonal = mesh.diagonal
    for away, segments in ((0.0, 16), (0.9, 16), (1.9, 16), (2.1, 8), (4.2, 4), (8.4, 2), (1e6, 2)):
        run(device, prepared, seen_from(away * diagonal))
        assert prepared.counters()["segments"] == segments
        assert prepared.check().passed
        (surface,) = prepared.output
        assert surface is not None
        assert surface.vertex_count == prepared.result()[0].vertex_count
        assert surface.triangle_count == mesh.triangle_count * segments**2
    run(device, prepared)
    assert as_bytes(prepared.result()[0]) == as_bytes(draw(device, mesh, 16).result()[0])


def test_pattern_of_many_levels_is_drawn_on_either_side_of_every_change(device):
    mesh = icosphere(1)
    prepared = Pattern(device, mesh, Params(64, levels=7, near=1.0))
    raster = Raster(device, prepared.output, 60, 48)
    for away in (0.5, 1.9, 2.1, 70.0, 1e3, 0.5):
        away *= mesh.diagonal
        view = look_at((0, 0, away + 1), (0, 0, 0), size=(60, 48), near=away / 10, far=3 * away)
        run(device, prepared, Frame(view), raster)
        own = Raster(device, prepared.output, 60, 48)
        own(prepared.output, Frame(view), Timeline())
        np.testing.assert_array_equal(raster.image(), own.image())


def test_pattern_counts_memory_as_the_paper_and_as_it_is(device):
    prepared = draw(device, icosphere(1), 64)
    assert prepared.counters()["vertices_square_grid"] == 4225
    footprint = prepared.footprint()
    assert footprint.stored_vertices == 2145
    assert footprint.static_vertices == 80 * 2145
    assert footprint.stored_bytes < footprint.static_bytes / 40


def test_pattern_of_nothing_is_nothing(device):
    for way in ("batched", "per_triangle"):
        prepared = draw(device, EMPTY, 8, draw=way)
        assert prepared.result()[0].triangle_count == 0
        assert prepared.welded().vertex_count == 0
        assert prepared.check().passed


def test_pattern_of_degenerate_triangles_is_finite(device):
    # zero area, a corner twice, opposite normals that cancel half-way, a point at the wave's origin
    mesh = TriangleMesh(
        [[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]],
        [[0, 1, 2], [0, 0, 1], [3, 1, 0], [3, 3, 3]],
        normals=[[0, 0, 1], [0, 0, -1], [0, 0, 0], [1, 0, 0]],
    )
    for mode in ({}, SINE):
        prepared = draw(device, mesh, 4, **mode)
        made = prepared.result()[0]
        assert prepared.check().passed
        assert np.abs(np.linalg.norm(made.normals, axis=1) - 1).max() < UNIT_LENGTH


@pytest.mark.parametrize("scale", [1e-25, 1e-6, 1e6, 1e30])
def test_pattern_works_at_any_scale(device, scale):
    mesh = shaken(icosphere(1))
    scaled = TriangleMesh(mesh.positions * np.float32(scale), mesh.triangles)
    for mode in ({}, SINE):
        assert draw(device, scaled, 5, **mode).check().passed


@given(
    st.lists(
        st.lists(st.floats(-1e6, 1e6, width=32), min_size=3, max_size=3), min_size=3, max_size=9
    ),
    st.integers(1, 9),
    st.data(),
)
@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_pattern_of_any_triangles_agrees_with_reference_and_welds(device, points, segments, data):
    corner = st.integers(0, len(points) - 1)
    faces = data.draw(st.lists(st.tuples(corner, corner, corner), min_size=1, max_size=6))
    prepared = draw(device, TriangleMesh(points, faces), segments)
    assert prepared.check().passed
    proper = [face for face in faces if len(set(face)) == 3]
    if not proper:
        return
    # what welding by number calls one vertex is one exactly; a product that underflows may leave either zero
    prepared = draw(device, TriangleMesh(points, proper), segments)
    apart, welded = prepared.result()[0], prepared.welded()
    for name in ("positions", "normals"):
        shared, own = getattr(welded, name), getattr(apart, name)
        assert np.array_equal(shared[welded.triangles], own[apart.triangles])


@pytest.mark.parametrize(
    ("params", "text"),
    [
        ({"segments": 0}, "segments: expected 1 to 4096, got 0"),
        ({"segments": 12, "levels": 4}, "levels: expected halvings of 12 segments, got 4"),
        ({"draw": "all"}, "draw: expected one of batched, per_triangle, got 'all'"),
        ({"amplitude": 2.0}, "amplitude: expected -1 to 1, got 2.0"),
        ({"near": 0.0}, "near: expected more than 0, got 0.0"),
    ],
)
def test_pattern_refuses_wrong_params(params, text):
    with pytest.raises(ValueError, match=text):
        Params(**params)


def test_pattern_refuses_coordinates_that_overflow(device):
    with pytest.raises(ValueError, match=r"points: expected coordinates up to 1e\+38"):
        Pattern(device, TriangleMesh(np.float32([[2e38, 0, 0]] * 3), [[0, 1, 2]]), Params(2))


def test_refine_maps_coarse_vertices(device):
    mesh = TriangleMesh([*tetrahedron().positions, [5, 5, 5]], tetrahedron().triangles)
    result = refine(device, mesh, segments=3)
    assert result.mesh.vertex_count == 4 * 9 // 2 + 2
    assert result.vertex_map is not None
    assert result.vertex_map[4] == 0xFFFFFFFF  # no triangle uses it
    assert np.array_equal(result.mesh.positions[result.vertex_map[:4]], mesh.positions[:4])
    apart = refine(device, mesh, segments=3, weld=False)
    assert apart.vertex_map is None
    assert apart.mesh.vertex_count == 4 * lattice_vertex_count(3)


def test_refine_interpolates_other_attributes(device):
    mesh = TriangleMesh(
        TRIANGLE.positions,
        TRIANGLE.triangles,
        uvs=[[0, 0], [4, 0], [0, 4]],
        colours=[[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        tags=[[0, 0, 7], [1, 0, 7], [0, 1, 7]],
    )
    for weld in (True, False):
        made = refine(device, mesh, segments=4, weld=weld).mesh
        x, y = made.positions[:, 0], made.positions[:, 1]
        assert np.allclose(made.uvs, np.stack([4 * x, 4 * y], 1), atol=4 * ROUNDING32)
        assert np.allclose(made.colours, np.stack([1 - x - y, x, y], 1), atol=ROUNDING32)
        assert np.allclose(made.tags, np.stack([x, y, 0 * x + 7], 1), atol=7 * ROUNDING32)


def test_largest_error_finds_a_wrong_vertex():
    P = TRIANGLE.positions[None].astype(float)
    N = np.broadcast_to([0.0, 0.0, 1.0], (1, 3, 3))
    points, normals, _ = refined(flat, P, N, lattice_weights(4), Wave(0.1, 3.0, 0.5))
    assert largest_error(points, normals, P, N, Wave(0.1, 3.0, 0.5), flat, lattice_weights(4)) == 0
    for moved in (1e-3, np.nan):
        wrong = points.copy()
        wrong[0, 7, 1] += moved
        assert (
            not largest_error(wrong, normals, P, N, Wave(0.1, 3.0, 0.5), flat, lattice_weights(4))
            <= 1e-4
        )


def test_wave_travels_away_from_the_origin(device):
    # h(r, t) = h(r - t * length, 0): seen on a flat sheet, whose normals are all one axis
    mesh = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], [[0, 0, 1]] * 3)
    options = {"amplitude": 0.01, "waves": 2.0}
    length, later = mesh.diagonal / 2.0, 0.2

    def heights(time):
        (made,) = draw(device, mesh, 256, Frame(time=time), **options).result()
        along = made.positions[np.abs(made.positions[:, 1]) < 1e-7]
        return along[np.argsort(along[:, 0])].astype(float)

    still, moved = heights(0.0), heights(later)
    x = moved[:, 0][moved[:, 0] > later * length]
    expected = np.interp(x - later * length, still[:, 0], still[:, 2])
    assert np.abs(moved[-len(x) :, 2] - expected).max() < 2e-4 < 0.01 * mesh.diagonal
