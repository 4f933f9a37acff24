from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, torus
from lodbench.kernels import simplify_mesh
from lodbench.kernels.cluster.grid import Grid
from lodbench.kernels.cluster.level_chain import host
from lodbench.kernels.cluster.level_chain.host import LevelChain
from lodbench.kernels.cluster.level_chain.params import Params
from lodbench.kernels.cluster.level_chain.reference import halved, simplify
from lodbench.kernels.cluster.quadric_clustering import SYSTEM as CLUSTERING
from lodbench.kernels.cluster.quadric_clustering import Params as Clustering
from lodbench.kernels.cluster.quadric_clustering.reference import NO_VERTEX
from lodbench.kernels.system import run
from tests.kernels.cluster.meshes import (
    cube,
    flat_lattice,
    single_triangle,
    tetrahedron,
    wavy_sheet,
)
from tests.tolerances import ROUNDING32

WAYS = {
    "serial": {},
    "launches": {},
    "separate": {"strategy": "separate"},
    "fixed_point": {"accumulate": "fixed_point"},
    "no_duplicates": {"remove_duplicates": True},
}
BALL, RING = icosphere(4), torus(90, 60)


@pytest.fixture(params=WAYS)
def way(request, monkeypatch):
    if request.param != "serial":
        monkeypatch.setattr(host, "SERIAL", 0)
    return WAYS[request.param]


def chain(device, mesh, **params):
    prepared = host.prepare(device, mesh, Params(**params))
    run(device, prepared)
    return prepared


def clustered(device, mesh, **params):
    prepared = CLUSTERING.prepare(device, mesh, Clustering(**params))
    run(device, prepared)
    return prepared


def outcome(meshes):
    return [(mesh.positions.tobytes(), mesh.triangles.tobytes()) for mesh in meshes]


@pytest.mark.parametrize("cells", [1, 2, 13, 29.7, (33, 5, 9), (1, 40, 3), (40, 1, 3)])
@pytest.mark.parametrize("mesh", [BALL, RING, wavy_sheet(), cube(7), flat_lattice(9)])
def test_level_chain_agrees_with_clustering_the_mesh_on_each_grid(device, mesh, cells, way):
    # the reference clusters the mesh itself, so its triangles are those of no decimated level
    prepared = chain(device, mesh, cells=cells, levels=5, **way)
    check = prepared.check()
    assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"
    assert len(prepared.result()) == 5


def test_level_chain_check_sees_a_triangle_that_a_level_lacks(device):
    prepared = chain(device, RING, cells=20)
    level = prepared.levels[2]
    vertices, triangles = level.size(device.read)
    fewer = device.upload("counts", np.array([vertices, triangles - 1], np.uint32))
    prepared.levels[2] = replace(level, counts=fewer)
    assert not prepared.check().passed


@pytest.mark.parametrize("cells", [16, 22.5, (8, 16, 4)])
def test_level_chain_in_fixed_point_is_clustering_at_each_grid_to_the_bit(device, cells):
    for number, mesh in enumerate(
        chain(device, RING, cells=cells, levels=3, accumulate="fixed_point").result()
    ):
        part = 1 << number
        coarse = tuple(n // part for n in cells) if isinstance(cells, tuple) else cells / part
        expected = clustered(device, RING, cells=coarse, accumulate="fixed_point").result()
        assert outcome([mesh]) == outcome(expected)


def test_level_chain_map_is_that_of_clustering_at_the_grid_to_rounding(device):
    made = chain(device, BALL, cells=30, levels=4)
    for number, level in enumerate(made.levels[1:], 1):
        direct = clustered(device, BALL, cells=30 / (1 << number))
        expected = device.read(direct.sums).sum(0, dtype=np.float64)
        (found,) = device.read(level.sums).astype(np.float64)
        assert found.shape == expected.shape
        found[:, 9], expected[:, 9] = 0, 0  # surviving corners: only whether there are any
        assert np.array_equal(found[:, 15], expected[:, 15]), "corners are counted exactly"
        assert np.abs(found - expected).max() < 100 * ROUNDING32 * np.abs(expected).max()


def test_level_chain_of_one_level_is_quadric_clustering_to_the_bit(device):
    made = chain(device, RING, cells=25, levels=1)
    other = clustered(device, RING, cells=25)
    assert outcome(made.result()) == outcome(other.result())
    assert np.array_equal(made.vertex_map(), other.vertex_map())
    assert made.level_maps() == []


def test_level_chain_first_level_and_bytes_do_not_depend_on_what_follows(device, monkeypatch):
    whole = chain(device, RING, cells=25, levels=4)
    expected = outcome(whole.result())
    assert outcome(chain(device, RING, cells=25, levels=2).result()) == expected[:2]
    run(device, whole)
    assert outcome(whole.result()) == expected
    monkeypatch.setattr(host, "SERIAL", 0)
    assert outcome(chain(device, RING, cells=25, levels=4).result()) == expected


@pytest.mark.parametrize("name", ["igea", "fandisk"])
def test_level_chain_of_scans_agrees_with_clustering_them(device, data_folder, name):
    path = next((data_folder / "meshes").glob(f"{name}*.ply"), None)
    if path is None:
        pytest.skip(f"no {name} in the data folder")
    check = chain(device, catalogue.load(path.stem).surface, target_reduction=0.9).check()
    assert check.passed, f"{check.what}: {check.value}"


def test_level_chain_maps_compose(device, way):
    mesh = TriangleMesh(np.concatenate([RING.positions, [[0, 0, 0]]]), RING.triangles)
    made = chain(device, mesh, cells=27, levels=4, **way)
    reached = made.vertex_map()
    levels, references = made.result(), simplify(mesh, made.params)
    assert reached[-1] == NO_VERTEX, "no triangle uses it, nor its cell"
    for level_map, mesh_before, mesh_after, reference in zip(
        made.level_maps(), levels, levels[1:], references[1:], strict=False
    ):
        assert level_map.shape == (mesh_before.vertex_count,)
        assert level_map[level_map != NO_VERTEX].max() < mesh_after.vertex_count
        # each triangle of a level is one of the level before, moved along
        moved = level_map[mesh_before.triangles]
        a, b, c = moved.T
        kept = moved[(a != b) & (b != c) & (c != a) & (moved != NO_VERTEX).all(1)]
        if not made.params.remove_duplicates:
            assert np.array_equal(kept, mesh_after.triangles)
        known = reached != NO_VERTEX
        reached = np.where(known, level_map[np.where(known, reached, 0)], NO_VERTEX)
        known = reached != NO_VERTEX
        assert np.array_equal(reached[known], reference.vertex_map[known])


@settings(max_examples=25, deadline=None)
@given(
    counts=st.tuples(*3 * [st.integers(1, 9)]),
    seed=st.integers(0, 2**31),
    levels=st.integers(2, 5),
)
def test_level_chain_of_any_triangles_agrees_on_any_grid(device, counts, seed, levels):
    random = np.random.default_rng(seed)
    points = random.random((40, 3)).astype(np.float32)
    soup = TriangleMesh(points, random.integers(0, 40, (90, 3)))
    check = chain(device, soup, cells=counts, levels=levels).check()
    assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"


@given(counts=st.tuples(*3 * [st.integers(1, 499)]), seed=st.integers(0, 2**31))
def test_halved_grid_halves_the_cell_of_every_position(counts, seed):
    positions = (np.random.default_rng(seed).random((64, 3)) * 7 - 3).astype(np.float32)
    grid = Grid.over(positions.min(0), positions.max(0), counts)
    coarse = halved(grid)
    x, y, _ = grid.counts
    cells = grid.cells_of(grid.points(positions))
    fine = np.stack([cells % x, cells // x % y, cells // x // y])
    x, y, _ = coarse.counts
    expected = (fine[2] // 2 * y + fine[1] // 2) * x + fine[0] // 2
    assert np.array_equal(coarse.cells_of(coarse.points(positions)), expected)


def degenerate():
    ball = icosphere(2)
    twice = np.concatenate([ball.triangles, ball.triangles, ball.triangles[:, ::-1]])
    flat = np.zeros((9, 3))
    return {
        "empty": TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int)),
        "points": TriangleMesh(ball.positions, np.zeros((0, 3), int)),
        "triangle": single_triangle(),
        "tetrahedron": tetrahedron(),
        "no area": TriangleMesh(flat, [[0, 1, 2], [3, 4, 5]]),
        "duplicates": TriangleMesh(ball.positions, twice),
        "small": TriangleMesh(ball.positions * 1e-30, ball.triangles),
        "large": TriangleMesh(ball.positions * 1e30, ball.triangles),
        "far": TriangleMesh(ball.positions + 1e6, ball.triangles),
    }


@pytest.mark.parametrize("name", degenerate())
def test_level_chain_of_nasty_meshes_passes_its_check(device, name, way):
    made = chain(device, degenerate()[name], cells=11, levels=6, **way)
    assert made.check().passed, made.check()
    for mesh in made.result():
        assert np.isfinite(mesh.positions).all()


def test_level_chain_by_the_verb_has_levels_maps_and_the_origin(device):
    points = RING.positions.astype(np.float64) + 1e7
    result = simplify_mesh(
        device, (points, RING.triangles), cells=20, method="level_chain", levels=3
    )
    assert [level.triangle_count for level in result.levels] == [
        result.counters[key] for key in ("triangles", "level_2_triangles", "level_3_triangles")
    ]
    assert result.mesh is result.levels[0] or outcome([result.mesh]) == outcome(result.levels[:1])
    assert [len(found) for found in result.level_maps] == [
        level.vertex_count for level in result.levels[:2]
    ]
    for level in result.levels:
        assert np.abs(level.points - 1e7).max() < 3


def test_level_chain_target_is_the_first_levels(device):
    result = simplify_mesh(device, BALL, target_reduction=0.8, method="level_chain")
    wanted = BALL.triangle_count // 5
    assert 0.95 * wanted <= result.mesh.triangle_count <= wanted
    assert result.counters["target_gap"] == wanted - result.mesh.triangle_count
    whole = simplify_mesh(device, BALL, target_reduction=0, method="level_chain")
    assert len(whole.levels) == 1
    assert whole.level_maps == ()


@pytest.mark.parametrize(("levels", "error"), [(0, ValueError), (13, ValueError), (2.5, TypeError)])
def test_level_chain_refuses_other_numbers_of_levels(device, levels, error):
    with pytest.raises(error, match="levels: expected"):
        simplify_mesh(device, BALL, cells=9, method="level_chain", levels=levels)


def test_level_chain_is_what_prepare_gives(device):
    assert isinstance(chain(device, BALL, cells=9), LevelChain)
