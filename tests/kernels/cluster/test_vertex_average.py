import numpy as np
import pytest

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, torus
from lodbench.kernels import simplify, simplify_mesh
from lodbench.kernels.cluster.vertex_average import SYSTEM, Params
from lodbench.kernels.system import run


def prepared(device, mesh, **params):
    made = SYSTEM.prepare(device, mesh, Params(**params))
    run(device, made)
    return made


@pytest.mark.parametrize("cells", [1, 2, 7.5, (3, 5, 9), 64])
@pytest.mark.parametrize("name", ["torus_2k", "icosphere_3", "terrain_2k"])
def test_vertices_are_means_of_their_cells(device, name, cells):
    check = prepared(device, catalogue.load(name).surface, cells=cells).check()
    assert check.passed, f"{check.what}: {check.value}"


@pytest.mark.parametrize("name", ["igea", "fandisk"])
def test_vertices_of_scans_are_means_of_their_cells(device, data_folder, name):
    path = next((data_folder / "meshes").glob(f"{name}*.ply"), None)
    if path is None:
        pytest.skip(f"no {name} in the data folder")
    check = prepared(device, catalogue.load(path.stem).surface, target_reduction=0.9).check()
    assert check.passed, f"{check.what}: {check.value}"


def test_a_target_is_met_and_the_map_leads_to_the_mean(device):
    mesh = icosphere(5)
    result = simplify_mesh(device, mesh, target_count=2000, method="vertex_average")
    assert 1900 <= result.mesh.triangle_count <= 2000
    assert result.counters["target_gap"] == 2000 - result.mesh.triangle_count
    assert result.vertex_map is not None
    own = result.vertex_map != 0xFFFFFFFF
    sums = np.zeros((result.mesh.vertex_count, 4))
    np.add.at(sums, result.vertex_map[own], np.c_[mesh.positions[own], np.ones(own.sum())])
    assert np.abs(sums[:, :3] / sums[:, 3:] - result.mesh.positions).max() < 1e-6


def test_number_of_maps_rounds_and_work_is_repeated_bit_for_bit(device):
    mesh = torus(90, 60)
    one, two, many = (
        prepared(device, mesh, cells=20, chunks=chunks).result()[0] for chunks in (2, 2, 64)
    )
    assert one.positions.tobytes() == two.positions.tobytes()
    assert np.array_equal(one.triangles, many.triangles)
    assert np.abs(one.positions - many.positions).max() < 1e-6


def test_a_million_vertices_in_one_cell_lose_nothing(device):
    # scattered points: what one addition loses another gives back, so this bounds the sum, not its carrying
    random = np.random.default_rng(0)
    points = random.random((1 << 20, 3), np.float32)
    points[:3] = 0, 0, 0
    faces = [[0, 1, 2]]
    made = prepared(device, TriangleMesh(points, faces), cells=1)
    sums = made.device.read(made.solved)[0, :3] / made.grid.prescale * made.grid.unit
    centre = points.astype(float).mean(0) - made.grid.low / made.grid.prescale
    assert np.abs(sums - centre).max() < 1e-5


def test_roundings_that_all_go_one_way_are_made_good(device):
    # a million times the same point: each addition rounds alike, so what is lost adds up
    points = np.full((1 << 20, 3), 0.7, np.float32)
    points[:2] = (0, 0, 0), (1, 1, 1)
    made = prepared(device, TriangleMesh(points, [[0, 1, 2]]), cells=1, chunks=1)
    mean = made.device.read(made.solved)[0, :3] / made.grid.prescale * made.grid.unit
    assert np.abs(mean - points.astype(float).mean(0)).max() < 1e-6


def test_duplicates_go_where_asked(device):
    mesh = catalogue.load("terrain_2k").surface
    both = TriangleMesh(mesh.positions, np.concatenate([mesh.triangles, mesh.triangles[:, ::-1]]))
    kept = prepared(device, both, cells=10, remove_duplicates=True)
    assert kept.check().passed
    assert kept.counters()["triangles"] < prepared(device, both, cells=10).counters()["triangles"]


def test_creases_are_rounded_where_quadrics_keep_them(device):
    # the corner of a cube: the mean lies inside, the planes meet in it
    axis = np.linspace(0, 1, 9, dtype=np.float32)
    u, v = (a.ravel() for a in np.meshgrid(axis, axis))
    sides = [np.stack(np.roll([u, v, np.zeros_like(u)], k, axis=0), axis=1) for k in range(3)]
    i = np.arange(8)
    corner = (9 * i[:, None] + i).ravel()
    quads = np.stack([corner, corner + 1, corner + 10, corner, corner + 10, corner + 9], 1)
    faces = np.concatenate([quads.reshape(-1, 3) + 81 * k for k in range(3)])
    points = np.concatenate(sides)
    mean, _ = simplify(points, faces, cells=4, method="vertex_average")
    quadric, _ = simplify(points, faces, cells=4)
    assert np.linalg.norm(quadric, axis=1).min() < 0.02 < np.linalg.norm(mean, axis=1).min()
