import numpy as np
import pytest

from lodbench.datasets_gen import triangles
from lodbench.datasets_gen.surfaces import TriangleMesh
from tests.datasets_gen.topology import topology
from tests.tolerances import ROUNDING32, UNIT_LENGTH

CLOSED = {
    "icosphere_0": (lambda: triangles.icosphere(0), 20, 2),
    "icosphere_3": (lambda: triangles.icosphere(3), 1280, 2),
    "geodesic_1": (lambda: triangles.geodesic_sphere(1), 20, 2),
    "geodesic_2": (lambda: triangles.geodesic_sphere(2), 80, 2),
    "geodesic_7": (lambda: triangles.geodesic_sphere(7), 980, 2),
    "displaced_1": (lambda: triangles.displaced_icosphere(1), 20, 2),
    "displaced_32": (lambda: triangles.displaced_icosphere(32), 20480, 2),
    "sphere_6": (lambda: triangles.sphere(6), 6, 2),
    "sphere_10": (lambda: triangles.sphere(10), 10, 2),
    "sphere_100": (lambda: triangles.sphere(100), 100, 2),
    "sphere_1000": (lambda: triangles.sphere(1000), 1000, 2),
    "torus_3_3": (lambda: triangles.torus(3, 3), 18, 0),
    "torus_40_20": (lambda: triangles.torus(40, 20), 1600, 0),
}


@pytest.mark.parametrize("make, count, euler", CLOSED.values(), ids=list(CLOSED))
def test_closed_mesh_is_a_welded_outward_manifold(make, count, euler):
    mesh = make()
    found = topology(mesh)
    assert mesh.triangle_count == count
    assert (found.euler, found.border, found.repeated, found.unused) == (euler, 0, 0, 0)
    assert found.volume > 0


@pytest.mark.parametrize("make, count, euler", CLOSED.values(), ids=list(CLOSED))
def test_given_normals_are_unit_and_point_outwards(make, count, euler):
    mesh = make()
    assert np.abs(np.linalg.norm(mesh.normals, axis=1) - 1).max() < UNIT_LENGTH
    from_triangles = TriangleMesh(mesh.positions, mesh.triangles).with_normals().normals
    assert (mesh.normals * from_triangles).sum(1).min() > 0.5


@pytest.mark.parametrize("name", ["icosphere_3", "geodesic_7", "sphere_100"])
def test_sphere_is_the_unit_sphere_with_exact_normals(name):
    mesh = CLOSED[name][0]()
    assert np.abs(np.linalg.norm(mesh.positions, axis=1) - 1).max() < UNIT_LENGTH
    assert np.array_equal(mesh.normals, mesh.positions)


def test_icosphere_keeps_the_vertices_of_the_level_before():
    coarse, fine = triangles.icosphere(2), triangles.icosphere(3)
    assert np.array_equal(fine.positions[: coarse.vertex_count], coarse.positions)


def test_icosphere_edge_midpoints_are_geodesic():
    mesh = triangles.icosphere(1)
    a, ab, _ = mesh.positions[mesh.triangles[0]].astype(np.float64)
    _, b, _ = mesh.positions[mesh.triangles[1]].astype(np.float64)[[0, 1, 2]]
    assert np.abs(np.cross(a + b, ab)).max() < ROUNDING32


@pytest.mark.parametrize("segments", [1, 9, 24, 64])
def test_displaced_icosphere_is_one_surface_at_every_size(segments):
    mesh = triangles.displaced_icosphere(segments)
    points = mesh.positions.astype(np.float64)
    radius = np.linalg.norm(points, axis=1)
    expected = 1 + sum(a * np.sin(points @ wave / radius) for a, wave in triangles._WAVES)
    # the waves turn the rounding of a direction into 26 times as much radius at the steepest
    assert np.abs(radius - expected).max() < 3 * ROUNDING32
    assert mesh.triangle_count == 20 * segments**2


def test_displaced_icosphere_normals_are_those_of_the_surface():
    mesh = triangles.displaced_icosphere(120)
    from_triangles = TriangleMesh(mesh.positions, mesh.triangles).with_normals().normals
    # a triangle spans about 1/100 of the radius and the waves turn by 26 / 100 over it
    assert (mesh.normals * from_triangles).sum(1).min() > 0.99


def test_displaced_icosphere_has_the_order_of_recursion():
    assert np.array_equal(
        triangles.displaced_icosphere(16).triangles, triangles.icosphere(4).triangles
    )
    # 48 = 3 * 2^4: the sixteen by sixteen children of a triangle of the coarse grid lie together
    coarse, fine = triangles.displaced_icosphere(3), triangles.displaced_icosphere(48)
    first = fine.positions[fine.triangles[:256]].reshape(-1, 3)
    corners = coarse.positions[coarse.triangles[0]]
    assert set(map(tuple, corners)) <= set(map(tuple, first))


@pytest.mark.parametrize("count", [5, 7, 4, 0, -2])
def test_sphere_refuses_counts_that_no_closed_one_has(count):
    with pytest.raises(ValueError, match="triangles: expected an even number"):
        triangles.sphere(count)


@pytest.mark.parametrize(
    "make",
    [
        lambda: triangles.icosphere(-1),
        lambda: triangles.geodesic_sphere(0),
        lambda: triangles.torus(2, 5),
        lambda: triangles.plane(0),
        lambda: triangles.terrain(0),
    ],
)
def test_too_few_segments_are_refused_by_name(make):
    with pytest.raises(ValueError, match=r"^\w+: expected at least \d, got -?\d"):
        make()


@pytest.mark.parametrize("make", [triangles.plane, triangles.terrain])
@pytest.mark.parametrize("columns", [1, 2, 33])
def test_open_grid_has_one_border(make, columns):
    mesh = make(columns)
    found = topology(mesh)
    assert mesh.triangle_count == 2 * columns**2
    assert (found.euler, found.border, found.repeated, found.unused) == (1, 4 * columns, 0, 0)
    assert (mesh.with_normals().normals[:, 2] > 0).all()
    assert mesh.uvs.min() == 0 and mesh.uvs.max() == 1


def test_plane_is_flat():
    mesh = triangles.plane(5, 3)
    assert mesh.triangle_count == 30
    assert not mesh.positions[:, 2].any()


def test_terrain_depends_on_its_seed_and_not_on_its_size():
    coarse, fine, other = triangles.terrain(16), triangles.terrain(64), triangles.terrain(16, 1)
    heights = fine.positions[:, 2].reshape(65, 65)[::4, ::4].ravel()
    assert np.abs(coarse.positions[:, 2] - heights).max() < ROUNDING32
    assert np.abs(coarse.positions[:, 2] - other.positions[:, 2]).max() > 0.01


def test_terrain_normals_are_those_of_the_surface():
    mesh = triangles.terrain(256, octaves=3)  # sixteen samples in the smallest cell
    from_triangles = TriangleMesh(mesh.positions, mesh.triangles).with_normals().normals
    inner = np.zeros((257, 257), bool)
    inner[1:-1, 1:-1] = True  # a border vertex has triangles on one side only
    assert (mesh.normals * from_triangles).sum(1)[inner.ravel()].min() > 0.99


def test_topology_tells_faults_apart():
    tetrahedron = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (9, 9, 9)]
    whole = topology(TriangleMesh(np.array(points), np.array(tetrahedron)))
    assert (whole.euler, whole.border, whole.repeated, whole.unused) == (2, 0, 0, 1)
    assert whole.volume == pytest.approx(1 / 6)
    opened = topology(TriangleMesh(np.array(points), np.array(tetrahedron[:3])))
    assert (opened.euler, opened.border) == (1, 3)
    flipped = topology(TriangleMesh(np.array(points), np.array([(0, 1, 2), *tetrahedron[1:]])))
    assert flipped.repeated == 3
