import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from lodbench.datasets_gen.read import read_mesh
from lodbench.datasets_gen.shapes import blob_with_ears
from lodbench.datasets_gen.surfaces import GeometryImage, TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, plane, torus
from lodbench.kernels.geometry_image.parameterisation import (
    MODES,
    NotOneToOne,
    NotSpherical,
    as_pictures,
    full_mesh,
    geometry_image,
    make,
    octahedron,
    spherical_map,
    stars,
    topology,
)
from lodbench.kernels.geometry_image.parameterisation.accept import flipped
from lodbench.kernels.geometry_image.parameterisation.device_stars import DeviceSweep
from lodbench.kernels.geometry_image.parameterisation.hierarchy import Corners, take_apart
from lodbench.kernels.geometry_image.parameterisation.image import resample
from lodbench.kernels.geometry_image.parameterisation.locate import Locator
from lodbench.kernels.geometry_image.parameterisation.rotation import candidates, squared_distances
from tests.tolerances import FLOAT64_STAR, SPHERE_DEGREE

SMALLEST = ("knight_1k", "goathead_od", "spot", "wingnut_od", "elephant_mesh")


def box():
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return TriangleMesh(corners, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def tetrahedron():
    return TriangleMesh(
        [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    )


def bicone(around=120):
    angle = np.arange(around) * 2 * np.pi / around
    rim = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    k, j = np.arange(around), (np.arange(around) + 1) % around
    top, bottom = np.full(around, around), np.full(around, around + 1)
    faces = np.concatenate([np.stack([k, j, top], 1), np.stack([j, k, bottom], 1)])
    return TriangleMesh(np.concatenate([rim, [[0, 0, 1], [0, 0, -1]]]), faces)


def reshaped(change, level=3):
    ball = icosphere(level)
    return TriangleMesh(change(ball.positions.astype(np.float64)), ball.triangles)


def spiky():
    out = np.where(np.arange(642)[:, None] % 60 == 0, 6.0, 1.0)
    return reshaped(lambda p: p * out)


def noisy():
    noise = np.random.default_rng(3).uniform(0.8, 1.2, (642, 1))
    return reshaped(lambda p: p * noise)


SHAPES = {
    "tetrahedron": tetrahedron,
    "box": box,
    "bicone": bicone,
    "sphere": lambda: icosphere(3),
    "needle": lambda: reshaped(lambda p: p * (1, 1, 20)),
    "pancake": lambda: reshaped(lambda p: p * (1, 1, 0.02)),
    "flat": lambda: reshaped(lambda p: p * (1, 1, 0)),
    "spikes": spiky,
    "noise": noisy,
    "coarse_steps": lambda: reshaped(lambda p: np.round(p * 3) / 3),
    "ears": lambda: blob_with_ears(24),
}


@pytest.mark.parametrize(
    ("shape", "seed"), [(s, 0) for s in SHAPES] + [("spikes", 1), ("coarse_steps", 1)]
)
def test_spherical_map_is_one_to_one(device, shape, seed):
    found = spherical_map(SHAPES[shape](), seed=seed, device=device, cache=False)
    assert found.flipped == 0
    assert found.degree == pytest.approx(1, abs=SPHERE_DEGREE)
    assert_allclose(np.linalg.norm(found.sphere, axis=1), 1, rtol=1e-12)


@pytest.mark.parametrize("name", SMALLEST)
def test_spherical_map_of_a_scan_is_one_to_one(device, data_folder, name):
    path = data_folder / "meshes" / f"{name}.ply"
    if not path.exists():
        pytest.skip(f"{name} is not in the data folder")
    for seed in range(3):
        found = spherical_map(read_mesh(path), seed=seed, device=device, cache=False)
        assert found.flipped == 0
        assert found.degree == pytest.approx(1, abs=SPHERE_DEGREE)


def test_every_direction_lies_in_exactly_one_spherical_triangle(device):
    found = spherical_map(spiky(), device=device, cache=False)
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(200, 3))
    a, b, c = (found.sphere[found.triangles[:, k]] for k in range(3))
    inside = np.ones((200, len(a)), bool)
    for p, q in ((a, b), (b, c), (c, a)):
        inside &= directions @ np.cross(p, q).T > 0
    assert_array_equal(inside.sum(axis=1), 1)


def doubled():
    ball = icosphere(1)
    n = ball.vertex_count
    return TriangleMesh(
        np.concatenate([ball.positions, ball.positions + 3]),
        np.concatenate([ball.triangles, ball.triangles + n]),
    )


def touching():
    """Two tetrahedra that share one vertex."""
    one = tetrahedron()
    other = np.where(one.triangles == 0, 0, one.triangles + 3)
    return TriangleMesh(
        np.concatenate([one.positions, -one.positions[1:]]),
        np.concatenate([one.triangles, other[:, ::-1]]),
    )


def finned():
    one = tetrahedron()
    return TriangleMesh(
        np.concatenate([one.positions, [[1, 1, 1]]]), np.concatenate([one.triangles, [[0, 1, 4]]])
    )


def one_turned():
    one = tetrahedron()
    faces = one.triangles.copy()
    faces[0] = faces[0, ::-1]
    return TriangleMesh(one.positions, faces)


REFUSED = {
    "torus": (lambda: torus(12, 8), "Euler number 0"),
    "open": (lambda: plane(3), "12 open edges"),
    "several": (doubled, "2 components"),
    "touching": (touching, "shared by separate fans"),
    "finned": (finned, "1 non-manifold edge "),
    "turned": (one_turned, "3 misoriented edges"),
    "nothing": (lambda: TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int)), "no triangles"),
    "no_area": (lambda: TriangleMesh(np.zeros((4, 3)), tetrahedron().triangles), "area 0"),
    "repeated": (lambda: TriangleMesh(np.eye(3), [(0, 1, 1)]), "naming a vertex twice"),
}


@pytest.mark.parametrize("shape", REFUSED)
def test_what_is_no_sphere_is_refused_with_what_was_found(shape):
    maker, said = REFUSED[shape]
    with pytest.raises(NotSpherical, match=said):
        spherical_map(maker())


def test_refusal_names_the_open_edges():
    holed = TriangleMesh(box().positions, box().triangles[1:])
    with pytest.raises(NotSpherical, match=r"3 open edges \(0-1, 0-3, 1-3\)"):
        spherical_map(holed)


def test_vertices_that_no_triangle_uses_are_left_out(device):
    ball = icosphere(2)
    padded = TriangleMesh(
        np.concatenate([np.full((5, 3), 9.0), ball.positions]), ball.triangles + 5
    )
    found = spherical_map(padded, device=device, cache=False)
    assert_array_equal(found.used, np.arange(5, 5 + ball.vertex_count))
    image = geometry_image(padded, n=4, device=device)
    assert np.linalg.norm(image.positions, axis=-1).max() <= 1 + 1e-6


def test_hierarchy_keeps_a_closed_surface_at_every_level():
    ball = spiky()
    levels, base = take_apart(ball.positions.astype(np.float64), ball.triangles.astype(np.int64))
    assert sum(len(level.removed) for level in levels) == ball.vertex_count - 4
    for faces in [level.faces for level in levels] + [base]:
        assert not topology(faces).faults
    assert len(base) == 4


def test_colouring_gives_no_two_neighbours_one_colour():
    ball = icosphere(3)
    faces = ball.triangles.astype(np.int64)
    vertices = np.arange(ball.vertex_count)
    colour = stars.colouring(Corners.of(faces, ball.vertex_count), vertices, 0)
    assert (colour[faces] != colour[np.roll(faces, 1, axis=1)]).all()
    assert colour.max() < 10


def test_energy_gradient_is_the_energy_s_slope():
    rng = np.random.default_rng(1)
    a = np.array([[0.1, 0.2, 1.0]])
    b, c = a + np.array([0.3, 0, 0]), a + np.array([0.1, 0.4, 0])
    a, b, c = (p / np.linalg.norm(p) for p in (a, b, c))
    rest = rng.uniform(0.5, 1, (1, 4))
    _, slope = stars.corner_energies(a, b, c, rest, gradient=True)
    for axis in range(3):
        step = np.eye(3)[axis] * 1e-6
        above, _ = stars.corner_energies(a + step, b, c, rest)
        below, _ = stars.corner_energies(a - step, b, c, rest)
        assert slope[0, axis] == pytest.approx((above[0] - below[0]) / 2e-6, rel=1e-6)


def test_device_moves_vertices_as_the_host_does(device):
    if not DeviceSweep.possible(device):
        pytest.skip("the device has no float64")
    surface = spiky().positions.astype(np.float64)
    faces = icosphere(3).triangles.astype(np.int64)
    moved = stars.Stars.of(surface, faces, np.arange(len(surface)), 0)
    on_host = icosphere(3).positions.astype(np.float64)
    on_host /= np.linalg.norm(on_host, axis=1, keepdims=True)
    on_device = on_host.copy()
    stars.sweep(on_host, moved, 0)
    DeviceSweep(device)(on_device, moved, 0)
    assert_allclose(on_device, on_host, atol=FLOAT64_STAR)


def test_host_alone_maps_one_to_one():
    assert spherical_map(box(), cache=False).flipped == 0
    assert spherical_map(icosphere(1), seed=1, cache=False).flipped == 0


def test_octahedral_map_and_its_inverse_round_trip():
    directions = np.random.default_rng(0).normal(size=(2000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    assert_allclose(
        octahedron.to_directions(octahedron.to_square(directions)), directions, atol=1e-12
    )


@pytest.mark.parametrize("n", [1, 2, 4])
def test_seam_duplicates_are_the_same_direction(n):
    directions = octahedron.sample_directions(n).reshape(-1, 3)
    own = octahedron.canonical(n)
    assert_allclose(directions[own.ravel()], directions, atol=1e-12)
    assert_array_equal(own.ravel()[own.ravel()], own.ravel())
    # a closed surface of 2 * 4^n triangles has 4^n + 2 vertices
    assert len(np.unique(own)) == 4**n + 2


def test_locator_finds_the_triangle_that_holds_each_sample(device):
    found = spherical_map(noisy(), device=device, cache=False)
    faces, weights = Locator(found.sphere, found.triangles).image(4, np.eye(3))
    corners = found.sphere[found.triangles[faces]]
    point = np.einsum("rck,rcki->rci", weights, corners)
    assert (weights >= 0).all()
    assert_allclose(
        point / np.linalg.norm(point, axis=-1, keepdims=True),
        octahedron.sample_directions(4),
        atol=1e-12,
    )


def test_distance_to_a_triangle_in_each_region():
    a, b, c = np.eye(3)
    points = np.array([(1, 1, 1), (2, 0, 0), (1, 1, 0), (0, 0, 3), (0, 0, 0)], float)
    # above the middle, beyond a, beside an edge, beyond c, below the middle
    expected = [4 / 3, 1, 0.5, 4, 1 / 3]
    assert_allclose(squared_distances(points, a, b, c), expected, atol=1e-12)


@pytest.mark.parametrize("n", [1, 3, 5])
def test_image_of_a_sphere_lies_on_it_and_closes(device, n):
    image = geometry_image(icosphere(4), n=n, device=device)
    # an icosphere's flat triangles lie up to 0.3 % inside the sphere
    assert_allclose(np.linalg.norm(image.positions, axis=-1), 1, atol=4e-3)
    own = octahedron.canonical(n)
    assert_array_equal(image.positions.reshape(-1, 3)[own], image.positions)
    assert_array_equal(image.normals.reshape(-1, 3)[own], image.normals)
    mesh = full_mesh(image)
    assert mesh.triangle_count == 2 * 4**n
    assert not topology(mesh.triangles).faults
    corners = mesh.positions[mesh.triangles]
    volume = np.linalg.det(corners.astype(np.float64)).sum() / 6
    assert 0 < volume < 4 / 3 * np.pi


def test_finer_images_lie_nearer_to_the_surface(device):
    ball = blob_with_ears(24)
    errors = []
    for n in (4, 5, 6):
        mesh = full_mesh(geometry_image(ball, n=n, turn="identity", device=device))
        corners = mesh.positions[mesh.triangles].astype(np.float64)
        errors.append(abs(np.linalg.det(corners).sum() - volume_of(ball)))
    assert errors[0] > errors[1] > errors[2]


def test_chosen_rotation_is_among_the_better_ones(device):
    ball = blob_with_ears(8)
    found = make(ball, 5, device=device)
    locator = Locator(found.spherical.sphere, found.spherical.triangles)

    def error(image):
        mesh = full_mesh(image)
        corners = mesh.positions[mesh.triangles].astype(np.float64)
        points = ball.positions[:, None].astype(np.float64)
        return squared_distances(points, *corners.transpose(1, 0, 2)[:, None]).min(1).mean()

    others = [error(resample(ball, found.spherical, 5, turn, locator)) for turn in candidates(9)]
    assert error(found.image) <= sorted(others)[2]


def volume_of(mesh):
    return np.linalg.det(mesh.positions[mesh.triangles].astype(np.float64)).sum()


def test_uniform_mip_level_closes():
    rng = np.random.default_rng(0)
    positions = rng.normal(size=(17, 17, 3))
    image = GeometryImage(positions, positions)
    for step in (1, 2, 4, 8):
        mesh = full_mesh(image, step)
        assert mesh.triangle_count == 2 * (16 // step) ** 2
        assert not topology(mesh.triangles).faults
    with pytest.raises(ValueError, match="step: expected a power of two below 16"):
        full_mesh(image, 16)


@pytest.mark.parametrize("mode", MODES)
def test_nearly_round_surface_is_mapped_by_every_mode(device, mode):
    found = spherical_map(reshaped(lambda p: p * (1, 1, 1.3), 2), mode=mode, device=device)
    assert found.flipped == 0


def test_ray_mode_says_when_it_fails():
    with pytest.raises(NotOneToOne, match=r"ray left [0-9]+ of 11520 triangles turned over"):
        spherical_map(blob_with_ears(24), mode="ray", cache=False)


def test_cache_gives_the_same_bits_and_survives_a_torn_file(device, tmp_path, monkeypatch):
    monkeypatch.setenv("LODBENCH_CACHE", str(tmp_path))
    first = make(box(), n=3, device=device)
    again = make(box(), n=3, device=device)
    assert not first.spherical.from_cache
    assert again.spherical.from_cache
    assert_array_equal(first.image.positions, again.image.positions)
    assert len(list((tmp_path / "parameterisation").glob("*.npz"))) == 2, "sphere and rotation"
    for held in (tmp_path / "parameterisation").glob("*.npz"):
        held.write_bytes(held.read_bytes()[:100])
    torn = make(box(), n=3, device=device)
    assert not torn.spherical.from_cache
    assert_array_equal(first.spherical.sphere, torn.spherical.sphere)
    assert_array_equal(first.rotation, torn.rotation)


def test_progress_reports_shares_and_time_left(device):
    said = []
    geometry_image(
        noisy(), n=3, device=device, cache=False, progress=lambda *words: said.append(words)
    )
    shares = [share for what, share, _ in said if what == "parameterisation"]
    assert shares == sorted(shares)
    assert shares[-1] == 1
    assert {what for what, *_ in said} == {"parameterisation", "rotation", "resampling"}
    assert any(left is not None and left >= 0 for *_, left in said)


def test_pictures_span_the_box(device):
    positions, normals = as_pictures(geometry_image(box(), n=3, device=device))
    assert positions.shape == normals.shape == (9, 9, 3)
    assert_array_equal(positions.min((0, 1)), 0)
    assert_array_equal(positions.max((0, 1)), 255)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"n": 0}, "n: expected 1 to 11, got 0"),
        ({"n": 12}, "n: expected 1 to 11, got 12"),
        ({"mode": "tutte"}, "mode: expected one of coarse_to_fine, cmcf, ray"),
        ({"turn": "left"}, "turn: expected one of best, identity"),
    ],
)
def test_arguments_out_of_range_are_refused(wrong, said):
    with pytest.raises(ValueError, match=said):
        geometry_image(box(), **wrong)


def test_triangle_without_area_counts_as_turned_over():
    sphere = np.array([(1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0)])
    faces = np.array([(0, 1, 2), (0, 2, 1), (0, 1, 1)])
    assert flipped(sphere, faces).tolist() == [1, 2]
