import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from lodbench.datasets_gen.surfaces import GeometryImage, TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, torus
from lodbench.harness.baselines import numpy_quadtree_lod
from lodbench.kernels.geometry_image import serial_traversal, uniform_grid
from lodbench.kernels.geometry_image.parameterisation import (
    NotSpherical,
    full_mesh,
    octahedron,
    topology,
)
from lodbench.kernels.geometry_image.quadtree_lod import (
    SYSTEM,
    Params,
    host,
    level_for,
    reference,
    simplify,
)
from lodbench.kernels.opencl.device import Device
from lodbench.kernels.system import Frame, View, run

WIDTH, HEIGHT = 640, 480


def bumpy_image(n, seed=0, height=0.05):
    """A sphere with bumps of two sizes, sampled straight into the image: seam duplicates bit-equal, closed."""
    directions = octahedron.sample_directions(n)
    waves = np.random.default_rng(seed).normal(size=(6, 3)) * np.array([3, 3, 3, 9, 9, 9])[:, None]
    radius = 1 + height * np.sin(directions @ waves.T).sum(-1) / 3
    own = octahedron.canonical(n)
    positions = (directions * radius[..., None]).astype(np.float32).reshape(-1, 3)[own]
    normals = directions.astype(np.float32).reshape(-1, 3)[own]
    return GeometryImage(positions, normals)


def view_from(eye, looking_at=(0, 0, 0), fov=0.8, orthographic=False):
    eye = np.asarray(eye, np.float64)
    forward = np.asarray(looking_at, np.float64) - eye
    forward /= np.linalg.norm(forward)
    side = np.cross(forward, (0.3, 0.9, 0.1))
    side /= np.linalg.norm(side)
    world = np.eye(4)
    world[:3, :3] = np.stack([side, np.cross(side, forward), -forward])
    world[:3, 3] = -world[:3, :3] @ eye
    f = 1 / np.tan(fov / 2)
    clip = np.diag([f * HEIGHT / WIDTH, f, -1.0, 0.0])
    clip[2, 3], clip[3, 2] = -0.1, -1.0
    if orthographic:
        clip = np.diag([0.5, 0.5, -0.01, 1.0])
    return View(eye, clip @ world, WIDTH, HEIGHT)


STILL = Frame()


def drawn(device, prepared, frame=STILL):
    run(device, prepared, frame)
    return prepared.result()[0]


def assert_closed(mesh):
    assert not topology(mesh.triangles).faults
    corners = mesh.positions[mesh.triangles].astype(np.float64)
    assert np.linalg.det(corners).sum() > 0, "outside out"


@pytest.mark.parametrize("n", [1, 2, 3, 6, 7])
@pytest.mark.parametrize("threshold", [0.0, 1e-4, 1e-3, 1e-2, 1.0])
def test_frame_equals_the_reference(device, n, threshold):
    prepared = SYSTEM.prepare(device, bumpy_image(n), Params(threshold=threshold))
    run(device, prepared)
    check = prepared.check()
    assert check.passed, f"{check.what}: {check.value}"


@pytest.mark.parametrize("placement", ["samples", "fitted"])
@pytest.mark.parametrize("error_metric", ["distance", "rms_share"])
@pytest.mark.parametrize("target", [8, 200, 3000])
def test_placement_and_measure_equal_the_reference(device, placement, error_metric, target):
    params = Params(placement=placement, error_metric=error_metric, target_count=target)
    prepared = SYSTEM.prepare(device, bumpy_image(6, height=0.2), params)
    assert_closed(drawn(device, prepared))
    check = prepared.check()
    assert check.passed, f"{check.what}: {check.value}"


def distance_to(image, mesh):
    """Root mean square distance of the image's samples from where the mesh has their directions: star-shaped only."""
    samples = image.positions.reshape(-1, 3).astype(np.float64)
    rays = samples / np.linalg.norm(samples, axis=1, keepdims=True)
    a, b, c = (mesh.positions[mesh.triangles[:, k]].astype(np.float64) for k in range(3))
    normal = np.cross(b - a, c - a)
    sides = [rays @ np.cross(p, q).T for p, q in ((a, b), (b, c), (c, a))]
    inside = np.minimum(np.minimum(*sides[:2]), sides[2]) >= -1e-9
    along = np.einsum("ij,ij->i", a, normal) / np.where(inside, rays @ normal.T, np.inf)
    return np.sqrt(((np.linalg.norm(samples, axis=1) - along.max(axis=1)) ** 2).mean())


def test_fitted_vertices_and_shares_lower_the_error(device):
    image = bumpy_image(5)
    errors = []
    for placement, error_metric in (
        ("samples", "distance"),
        ("samples", "rms_share"),
        ("fitted", "rms_share"),
    ):
        params = Params(placement=placement, error_metric=error_metric, target_count=300)
        errors.append(distance_to(image, drawn(device, SYSTEM.prepare(device, image, params))))
    assert errors[0] > errors[1] > errors[2]


@pytest.mark.parametrize("view", ["global", "node"])
@pytest.mark.parametrize("eye", [(0, 0, 2), (1.2, 0.5, -1), (30, 20, 10), (0.1, 0, 0), (0, 3e4, 0)])
def test_view_equals_the_reference(device, view, eye):
    prepared = SYSTEM.prepare(device, bumpy_image(6), Params(view=view, pixels=0.7))
    run(device, prepared, Frame(view_from(eye)))
    check = prepared.check()
    assert check.passed, f"{check.what}: {check.value}"


def test_surface_is_closed_at_any_threshold_and_from_anywhere(device):
    rng = np.random.default_rng(4)
    image = bumpy_image(6, height=0.3)
    by_threshold = SYSTEM.prepare(device, image, Params())
    by_node = SYSTEM.prepare(device, image, Params(view="node"))
    counts = set()
    for _ in range(60):
        by_threshold.threshold = 10 ** rng.uniform(-3, 0)
        mesh = drawn(device, by_threshold)
        assert_closed(mesh)
        counts.add(mesh.triangle_count)
    for _ in range(60):
        away = 10 ** rng.uniform(-1, 2)
        eye = rng.normal(size=3)
        mesh = drawn(device, by_node, Frame(view_from(eye / np.linalg.norm(eye) * away)))
        assert_closed(mesh)
        counts.add(mesh.triangle_count)
    assert len(counts) > 60, "the cases differ"


def test_random_nodes_close_without_any_balance_between_neighbours():
    rng = np.random.default_rng(0)
    image = bumpy_image(4)
    for _ in range(60):
        fine = [rng.random((1 << d, 1 << d)) < 0.4 for d in range(4)]
        fine[0][:] = False
        fine.append(np.ones((16, 16), bool))
        assert not topology(reference.merge(image, reference.node_states(fine)).triangles).faults


@pytest.mark.parametrize("eye", [None, (0.5, 1, 1.5), (1e5, 0, 0)])
def test_drawn_nodes_cover_the_image_once(device, eye):
    prepared = SYSTEM.prepare(device, bumpy_image(6), Params(view="node", threshold=2e-3))
    run(device, prepared, Frame(None if eye is None else view_from(eye)))
    states = prepared.states
    covered = np.zeros((64, 64), int)
    for depth, level in enumerate(states):
        size = 64 >> depth
        covered += np.kron(level == reference.DRAWN, np.ones((size, size), int))
    assert_array_equal(covered, 1)


def test_errors_and_bounds_hold_their_children(device):
    prepared = SYSTEM.prepare(device, bumpy_image(5), Params())
    errors, bounds = prepared.tree.read_errors(), prepared.tree.read_bounds()
    for depth in range(4):
        for child in range(4):
            inside = bounds[depth + 1][child >> 1 :: 2, child & 1 :: 2].astype(np.float64)
            outside = bounds[depth].astype(np.float64)
            assert (errors[depth] >= errors[depth + 1][child >> 1 :: 2, child & 1 :: 2]).all()
            reach = np.linalg.norm(inside[..., :3] - outside[..., :3], axis=-1) + inside[..., 3]
            assert (reach <= outside[..., 3] * (1 + 1e-6)).all()


@pytest.mark.parametrize("n", [1, 2, 5])
def test_packed_texture_holds_each_node_once(n):
    texture = np.zeros(3 << (2 * n - 1), int)
    for depth in range(n + 1):
        texture.reshape(-1, 1 << n)[reference.packed_slice(depth, n)] += 1
    assert texture.max() == 1
    assert texture.sum() == (4 ** (n + 1) - 1) // 3
    assert [level.shape[0] for level in reference.unpack(texture, n)] == [
        1 << d for d in range(n + 1)
    ]


def test_node_whose_error_is_the_threshold_is_not_fine_enough(device):
    # an octahedron's faces are flat: no node has an error, and still a threshold of 0 asks for all of them
    directions = octahedron.sample_directions(4)
    flat = directions / np.abs(directions).sum(axis=-1, keepdims=True)
    positions = (np.round(flat * 16) / 16).reshape(-1, 3)[octahedron.canonical(4)]
    prepared = SYSTEM.prepare(device, GeometryImage(positions, directions), Params(threshold=0.0))
    assert not any(level.any() for level in prepared.tree.read_errors()[1:])
    assert drawn(device, prepared).triangle_count == 2 * 4**4
    prepared.threshold = 1e-30
    assert drawn(device, prepared).triangle_count == 8
    assert prepared.check().passed


def test_static_buffer_is_the_full_image_as_a_mesh(device):
    prepared = SYSTEM.prepare(device, bumpy_image(5), Params(threshold=0.1))
    assert drawn(device, prepared).triangle_count < 2 * 4**5
    footprint = prepared.footprint()
    prepared.threshold = 0.0
    full = drawn(device, prepared)
    arrays = (full.positions, full.normals, full.triangles)
    assert footprint.static_bytes == sum(array.nbytes for array in arrays)
    assert footprint.static_vertices == full.vertex_count


def test_zero_threshold_draws_the_full_image_and_a_huge_one_an_octahedron(device):
    image = bumpy_image(5)
    full = drawn(device, SYSTEM.prepare(device, image, Params(threshold=0.0)))
    every = full_mesh(image)
    assert_array_equal(full.positions, every.positions)
    assert_array_equal(np.sort(full.triangles, axis=0), np.sort(every.triangles, axis=0))
    coarsest = drawn(device, SYSTEM.prepare(device, image, Params(threshold=1e6)))
    assert (coarsest.triangle_count, coarsest.vertex_count) == (8, 6)
    assert_closed(coarsest)


def scaled(image, exponent):
    return GeometryImage(image.positions * np.float32(2.0**exponent), image.normals)


@pytest.mark.parametrize("exponent", [-120, -60, -40, 40, 80, 120])
@pytest.mark.parametrize(
    "params",
    [
        Params(threshold=0.01),
        Params(placement="fitted", error_metric="rms_share", target_count=700),
        Params(view="node", pixels=6.0),
        Params(view="global", pixels=6.0),
    ],
    ids=["threshold", "fitted", "node", "global"],
)
def test_model_of_any_size_has_the_same_triangles(device, params, exponent):
    image, size = bumpy_image(5), 2.0**exponent
    seen = params.pixels == 6.0
    frames = [Frame(view_from((0, 0.4 * s, 3 * s))) if seen else Frame() for s in (1, size)]
    one, other = (SYSTEM.prepare(device, i, params) for i in (image, scaled(image, exponent)))
    expected, found = drawn(device, one, frames[0]), drawn(device, other, frames[1])
    assert 8 < expected.triangle_count < 2 * 4**5
    assert_array_equal(found.triangles, expected.triangles)
    # digits that a float32 cannot hold at this size are all that may be lost
    assert_allclose(found.positions, expected.positions * np.float32(size), rtol=0, atol=2.0**-149)
    assert other.check().passed
    assert other.counters()["threshold"] == pytest.approx(one.counters()["threshold"], rel=1e-7)


OTHERS = {
    "uniform_grid": lambda device, image: uniform_grid.SYSTEM.prepare(
        device, image, uniform_grid.Params(target_count=300)
    ),
    "serial_traversal": lambda device, image: serial_traversal.SYSTEM.prepare(
        device, image, Params(threshold=0.01)
    ),
    "numpy_quadtree_lod": lambda device, image: numpy_quadtree_lod.SYSTEM.prepare(
        device, image, numpy_quadtree_lod.Params(threshold=0.01)
    ),
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("exponent", [-120, 120])
@pytest.mark.parametrize("name", OTHERS)
def test_model_of_any_size_has_the_same_triangles_in_its_baselines(device, name, exponent):
    images = bumpy_image(5), scaled(bumpy_image(5), exponent)
    one, other = (OTHERS[name](device, image) for image in images)
    expected, found = drawn(device, one), drawn(device, other)
    assert 8 < expected.triangle_count < 2 * 4**5
    assert_array_equal(found.triangles, expected.triangles)
    assert_array_equal(found.positions, expected.positions * np.float32(2.0**exponent))
    assert other.check().passed


@pytest.mark.parametrize("threshold", [float("nan"), float("inf"), -1.0])
def test_threshold_that_is_no_error_is_refused(threshold):
    with pytest.raises(ValueError, match="threshold: expected"):
        Params(threshold=threshold)


@pytest.mark.parametrize("view", ["global", "node"])
def test_fewer_triangles_from_farther_away(device, view):
    prepared = SYSTEM.prepare(device, bumpy_image(6), Params(view=view, pixels=0.5))
    counts = [
        drawn(device, prepared, Frame(view_from((0, 0, away)))).triangle_count
        for away in (1.5, 3, 6, 12, 50, 500)
    ]
    assert counts == sorted(counts, reverse=True)
    assert counts[0] > 4 * counts[-1]


def test_error_on_screen_stays_below_the_tolerance(device):
    image, pixels = bumpy_image(6), 0.5
    prepared = SYSTEM.prepare(device, image, Params(view="node", pixels=pixels))
    view = view_from((0, 0.4, 3))
    run(device, prepared, Frame(view))
    scale = HEIGHT / 2 / np.tan(0.4)
    for depth, level in enumerate(prepared.states[:-1]):
        chosen = level == reference.DRAWN
        bound = prepared.tree.read_bounds()[depth][chosen].astype(np.float64)
        eye = view.eye * prepared.tree.scale
        away = np.linalg.norm(bound[:, :3] - eye, axis=1) - bound[:, 3]
        assert (
            prepared.tree.read_errors()[depth][chosen] * scale <= pixels * away * (1 + 1e-4)
        ).all()


@pytest.mark.parametrize("away", [2.5, 4, 30])
def test_one_threshold_keeps_to_the_tolerance_at_the_nearest_point(device, away):
    image = bumpy_image(6)
    prepared = SYSTEM.prepare(device, image, Params(view="global", pixels=0.5))
    view = view_from((0, 0, away))
    run(device, prepared, Frame(view))
    nearest = np.linalg.norm(image.positions - view.eye, axis=-1).min() * prepared.tree.scale
    scale = HEIGHT / 2 / np.tan(0.4)
    assert 0 < prepared.last.threshold * scale <= 0.5 * nearest


def test_orthographic_view_has_one_threshold_everywhere(device):
    prepared = SYSTEM.prepare(device, bumpy_image(6), Params(view="node", pixels=1.0))
    near = drawn(device, prepared, Frame(view_from((0, 0, 2), orthographic=True)))
    far = drawn(device, prepared, Frame(view_from((0, 0, 200), orthographic=True)))
    assert near.triangle_count == far.triangle_count
    # half the screen's 480 pixels for every 2 units
    assert prepared.last.threshold == pytest.approx(2 / HEIGHT * 2 * prepared.tree.scale)


def test_triangle_mesh_is_laid_out_first(device):
    ball = icosphere(3)
    prepared = SYSTEM.prepare(device, ball, Params(n=4, threshold=0.0))
    mesh = drawn(device, prepared)
    assert mesh.triangle_count == 512
    assert_closed(mesh)
    assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=1e-6)
    assert "parameterise" in prepared.setup.stage_s
    with pytest.raises(NotSpherical):
        SYSTEM.prepare(device, torus(12, 8), Params())


@pytest.mark.parametrize("target", [8, 100, 777, 2048])
def test_target_count_is_met_from_below(device, target):
    prepared = SYSTEM.prepare(device, bumpy_image(5), Params(target_count=target))
    mesh = drawn(device, prepared)
    assert 0.9 * target <= mesh.triangle_count <= target
    assert prepared.check().passed


def test_simplify_takes_meshes_and_images(device):
    ball = icosphere(3)
    from_mesh = simplify(device, ball, target_count=300)
    assert from_mesh.mesh.triangle_count <= 300
    assert from_mesh.counters["target_gap"] == 300 - from_mesh.mesh.triangle_count
    assert from_mesh.counters["n"] == level_for(ball.triangle_count) == 5
    from_image = simplify(device, bumpy_image(4), target_count=100)
    assert_closed(from_image.mesh)
    with pytest.raises(ValueError, match="cells: expected None"):
        simplify(device, ball, cells=8)


def test_flat_and_tiny_images_stay_finite(device):
    image = bumpy_image(3)
    for scale in (np.array([1, 1, 0]), np.zeros(3), np.full(3, 1e-18), np.full(3, 1e15)):
        squashed = GeometryImage(image.positions * scale, image.normals)
        for view in (None, view_from((0, 0, 3))):
            prepared = SYSTEM.prepare(device, squashed, Params(view="node"))
            mesh = drawn(device, prepared, Frame(view))
            assert not topology(mesh.triangles).faults
            assert np.isfinite(mesh.positions).all()


def test_work_group_size_changes_no_bit(device):
    image = bumpy_image(6)
    frame = Frame(view_from((0, 1, 2)))
    expected = None
    for options in ({}, {"local_size": 1}, {"local_size": 48}):
        other = Device.open(**options) if options else device
        mesh = drawn(other, SYSTEM.prepare(other, image, Params(view="node")), frame)
        got = (mesh.positions.tobytes(), mesh.triangles.tobytes())
        expected = expected or got
        assert got == expected, options


@pytest.mark.parametrize("run_length", [1, 16, 32])
def test_length_of_runs_changes_no_bit(device, monkeypatch, run_length):
    image = bumpy_image(6)
    frame = Frame(view_from((0, 1, 2)))
    params = Params(view="node", placement="fitted")
    expected = drawn(device, SYSTEM.prepare(device, image, params), frame)
    monkeypatch.setattr(host, "CPU_RUN", run_length)  # 1 is what a GPU gets
    got = drawn(device, SYSTEM.prepare(device, image, params), frame)
    assert_array_equal(got.positions, expected.positions)
    assert_array_equal(got.triangles, expected.triangles)


def test_no_triangles_in_no_triangles_out(device):
    empty = TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int))
    prepared = SYSTEM.prepare(device, empty, Params())
    assert drawn(device, prepared).triangle_count == 0
    assert prepared.check().passed


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"n": 12}, "n: expected 1 to 11"),
        ({"threshold": -1.0}, "threshold: expected at least 0"),
        ({"pixels": 0.0}, "pixels: expected more than 0"),
        ({"view": "all"}, "view: expected one of global, node, none"),
        ({"placement": "free"}, "placement: expected one of samples, fitted"),
        ({"error_metric": "area"}, "error_metric: expected one of distance, rms_share"),
        ({"target_count": 0}, "target_count: expected at least 1"),
    ],
)
def test_parameters_out_of_range_are_refused(wrong, said):
    with pytest.raises(ValueError, match=said):
        Params(**wrong)


@pytest.mark.perf
def test_surface_is_closed_a_thousand_times(device):
    rng = np.random.default_rng(1)
    image = bumpy_image(7, height=0.3)
    prepared = SYSTEM.prepare(device, image, Params(view="node"))
    for k in range(1000):
        if k % 2:
            prepared.threshold = 10 ** rng.uniform(-5, 0)
            mesh = drawn(device, prepared)
        else:
            eye = rng.normal(size=3) * 10 ** rng.uniform(-1, 4)
            mesh = drawn(device, prepared, Frame(view_from(eye, rng.normal(size=3))))
        assert_closed(mesh)
