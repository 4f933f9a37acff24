import math

import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster.octree import reference as whole_tree
from lodbench.kernels.cluster.octree import reference_boxes
from lodbench.kernels.cluster.probabilistic_octree import Params, reference
from lodbench.kernels.cluster.probabilistic_octree import simplify as simplify_to
from lodbench.kernels.cluster.probabilistic_octree.host import expected_collisions, prepare
from lodbench.kernels.opencl.device import Device
from lodbench.kernels.system import run
from tests.kernels.cluster.meshes import (
    cube,
    nine_point_plane,
    single_triangle,
    sphere,
    tetrahedron,
    wavy_sheet,
)
from tests.kernels.cluster.test_octree import nasty, open_edges, outcome

WAYS = {
    "full": {},
    "crowded": {"storage": 0.02},
    "roomy": {"storage": 20.0, "search": "binary"},
    "distinct": {"remove_duplicates": True},
    "randomised": {"construction": "randomised", "search": "binary"},
    "randomised_total": {"construction": "randomised", "rule": "total", "seed": 5},
}


def cluster(device, mesh, **params):
    prepared = prepare(device, mesh, Params(**params))
    run(device, prepared)
    return prepared


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(("levels", "error"), [(1, 0.1), (3, 0.01), (4, 0.0), (4, 0.003)])
@pytest.mark.parametrize(
    "make", [nine_point_plane, tetrahedron, single_triangle, cube, sphere, wavy_sheet]
)
def test_probabilistic_octree_agrees_with_reference(device, make, levels, error, way):
    check = cluster(device, make(), levels=levels, max_error=error, **WAYS[way]).check()
    assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"


@pytest.mark.parametrize("make", [cube, sphere, wavy_sheet])
def test_full_construction_without_collisions_gives_the_whole_trees_cut(device, make):
    mesh, levels = make(), 4
    tree = whole_tree.build(mesh, 1 << levels)
    errors = whole_tree.errors(tree, mesh, "rms")
    diagonal = mesh.diagonal / tree.grid.edge
    # thresholds between errors that are well apart, so that float32 decides alike
    order = np.unique(errors[errors > 1e-2])
    gaps = order[1:] / order[:-1]
    for k in np.argsort(gaps)[-3:]:
        limit = math.sqrt(order[k] * order[k + 1])
        joins, _ = reference_boxes.choose(tree, errors, limit, "rms", boxed=False)
        made, seed = None, 0
        while made is None or made.counters()["collisions"] > 0:
            made = cluster(
                device, mesh, levels=levels, storage=300.0, max_error=limit / diagonal, seed=seed
            )
            seed += 1
        assert made.check().passed
        expected, _, vertex_map = whole_tree.emit(tree, mesh, reference_boxes.cut(tree, joins))
        corners, other = vertex_map[mesh.triangles], made.vertex_map()[mesh.triangles]
        (mine,) = made.result()
        assert mine.triangle_count == expected.triangle_count
        assert mine.vertex_count == expected.vertex_count
        # the same partition of the corners, whatever its parts are called
        pairs = np.unique(np.stack([corners.ravel(), other.ravel()], 1), axis=0)
        assert len(pairs) == len(np.unique(corners)) == len(np.unique(other))


@pytest.mark.parametrize("storage", [0.05, 0.2, 1.0])
@pytest.mark.parametrize("construction", ["full", "randomised"])
def test_collisions_are_as_many_as_a_uniform_hash_has(device, construction, storage):
    for seed in range(3):
        counters = cluster(
            device, wavy_sheet(60), levels=5, max_error=0.01, storage=storage,
            construction=construction, seed=seed,
        ).counters()  # fmt: skip
        share, keys = counters["collisions_predicted"], counters["keys"]
        # collided keys come in pairs at least, which doubles the variance of independent ones
        sigma = math.sqrt(2 * share * (1 - share) / keys)
        assert abs(counters["collisions"] - share) <= 3 * sigma + 2 / keys


def test_expected_collisions_against_a_simulation():
    random, keys, slots = np.random.default_rng(0), 300, 500
    shares = []
    for _ in range(200):
        counts = np.bincount(random.integers(0, slots - 1, keys - 1), minlength=slots - 1)
        shares.append(counts[counts > 1].sum() / keys)
    assert np.mean(shares) == pytest.approx(expected_collisions(keys, slots), abs=0.01)
    assert expected_collisions(1, 10) == 0
    assert expected_collisions(5, 2) == 4 / 5


def test_a_lost_node_is_answered_for_by_a_coarser_one_on_its_way(device):
    mesh = wavy_sheet()
    for way in ({"storage": 0.01}, {"storage": 0.05, "construction": "randomised"}):
        made = cluster(device, mesh, levels=5, max_error=0.0, **way)
        read, table = made.read_table(), reference.write(mesh, made.params)
        keys = read["keys"][read["nodes"], 0].astype(np.int64)
        root = read["nodes"] == 0
        up = 5 - ((keys - 1) >> 27)
        own = (keys - 1) & 0x7FFFFFF
        assert (root | (own == table.codes >> (3 * up))).all()
        assert root.any() or way["storage"] > 0.01
        assert made.counters()["collisions"] > 0.1


def test_randomised_sums_are_right_on_average(device):
    # the root's area is a sum of samples whose weights undo their probabilities
    mesh = wavy_sheet()
    p = mesh.positions.astype(float)[mesh.triangles]
    area = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum() / 2
    found = []
    for seed in range(40):
        params = Params(levels=3, construction="randomised", seed=seed, max_error=0.0)
        table = reference.write(mesh, params)
        found.append(np.trace(table.A[0]) * table.grid.edge**2)
    # 1,200 samples of the root each
    assert np.mean(found) == pytest.approx(area, rel=0.02)


def test_randomised_construction_writes_the_finest_level_whole():
    params = Params(construction="randomised")
    corners = np.arange(100_000)
    assert reference.written(corners, 0, params).all()
    for up in range(1, 8):
        share = reference.written(corners, up, params).mean()
        assert share == pytest.approx(0.5**up, rel=0.15)


def test_root_keeps_a_slot_of_its_own():
    params = Params(levels=5, storage=0.01)
    keys = np.arange(1, 200_000)
    slots = reference.slots_of(keys, params)
    assert slots[0] == 0
    assert slots[1:].min() == 1
    assert slots.max() == params.slots - 1


@pytest.mark.parametrize("way", WAYS)
def test_probabilistic_octree_repeats_its_bytes(device, way):
    params = {"levels": 4, "max_error": 0.005, **WAYS[way]}
    expected = outcome(cluster(device, wavy_sheet(), **params))
    for options in ({}, {"local_size": 1}, {"local_size": 48}, {"one_core": True}):
        other = Device.open(**options)
        prepared = cluster(other, wavy_sheet(), **params)
        run(other, prepared)
        assert outcome(prepared) == expected, options


def test_probabilistic_octree_ignores_triangle_order_where_all_is_written(device):
    mesh = wavy_sheet()
    order = np.random.default_rng(1).permutation(mesh.triangle_count)
    other = TriangleMesh(mesh.positions, mesh.triangles[order])
    one = cluster(device, mesh, levels=5, max_error=0.003).result()[0]
    two = cluster(device, other, levels=5, max_error=0.003).result()[0]
    assert one.positions.tobytes() == two.positions.tobytes()


@pytest.mark.parametrize("storage", [0.02, 0.3])
def test_closed_input_has_no_open_edge(device, storage):
    mesh = sphere(40, 60)
    for search in ("linear", "binary"):
        result = simplify_to(
            device, mesh, max_error=0.002, levels=5, storage=storage, search=search
        )
        assert result.mesh.triangle_count
        assert not open_edges(result.mesh).any()


def test_probabilistic_octree_meets_its_target(device):
    result = simplify_to(device, wavy_sheet(60), target_reduction=0.75)
    target = result.counters["target"]
    assert 0.85 * target <= result.mesh.triangle_count <= target
    assert result.counters["levels"] == 6
    result = simplify_to(device, sphere(), target_count=10_000)
    assert np.array_equal(result.mesh.triangles, sphere().triangles)


@pytest.mark.parametrize("name", nasty())
def test_probabilistic_octree_survives_odd_meshes(device, name):
    mesh = nasty()[name]
    for params in (
        {"max_error": 0.01, "levels": 4},
        {"target_reduction": 0.5, "levels": 3, "construction": "randomised"},
    ):
        prepared = cluster(device, mesh, **params)
        check = prepared.check()
        assert check.passed, f"{params}: {check.what}: {check.value} > {check.tolerance}"
        assert len(prepared.vertex_map()) == mesh.vertex_count


@pytest.mark.parametrize(
    ("scale", "offset"), [(1e-30, 0), (1e30, 0), (3e38, 0), (1e-41, 0), (1e20, -3e22)]
)
def test_probabilistic_octree_at_any_scale_is_finite_and_right(device, scale, offset):
    mesh = sphere()
    mesh = TriangleMesh(mesh.positions.astype(np.float64) * scale + offset, mesh.triangles)
    prepared = cluster(device, mesh, max_error=0.01, levels=4)
    assert np.isfinite(prepared.result()[0].positions).all()
    check = prepared.check()
    assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"


@pytest.mark.parametrize(
    ("params", "text"),
    [
        ({"max_error": 0.1, "target_count": 5}, "target_reduction, target_count, max_error: expected one"),
        ({"storage": 0}, "storage: expected above 0 to 1000, got 0"),
        ({"levels": 9}, "levels: expected 1 to 8, got 9"),
        ({"search": "other"}, "search: expected one of linear, binary"),
    ],
)  # fmt: skip
def test_probabilistic_octree_params_refuse_what_does_not_fit(params, text):
    with pytest.raises(ValueError, match=text):
        Params(**params)
