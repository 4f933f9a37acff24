import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import terrain
from lodbench.harness.measure.quality import measure
from lodbench.kernels.cluster.octree import Params, reference, reference_boxes
from lodbench.kernels.cluster.octree import simplify as simplify_to
from lodbench.kernels.cluster.octree.host import prepare
from lodbench.kernels.cluster.octree.search import find_limit
from lodbench.kernels.cluster.quadric_clustering import simplify as simplify_on_grid
from lodbench.kernels.cluster.quadric_clustering.reference import NO_VERTEX
from lodbench.kernels.opencl.device import Device
from lodbench.kernels.system import run
from tests.kernels.cluster.meshes import (
    cube,
    flat_lattice,
    nine_point_plane,
    single_triangle,
    sphere,
    tetrahedron,
    wavy_sheet,
)

RULES = ("total", "rms", "maximum")
EMPTY = TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int))


def cluster(device, mesh, **params):
    prepared = prepare(device, mesh, Params(**params))
    run(device, prepared)
    return prepared


def passes(prepared):
    check = prepared.check()
    assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"


def outcome(prepared):
    (mesh,) = prepared.result()
    return mesh.positions.tobytes(), mesh.triangles.tobytes()


def open_edges(mesh):
    t = mesh.triangles
    edges = np.sort(np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]), axis=1)
    return np.unique(edges, axis=0, return_counts=True)[1] % 2


@pytest.mark.parametrize("more", [{}, {"shape": "cubes", "border": "none"}])
@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize(("levels", "error"), [(1, 0.2), (3, 0.02), (5, 0.0), (5, 0.003)])
@pytest.mark.parametrize(
    "make", [nine_point_plane, tetrahedron, single_triangle, cube, sphere, wavy_sheet]
)
def test_octree_agrees_with_reference(device, make, levels, error, rule, more):
    passes(cluster(device, make(), levels=levels, max_error=error, rule=rule, **more))


@pytest.mark.parametrize("border", ["quadrics", "none", "keep"])
@pytest.mark.parametrize("reduction", [0.3, 0.7, 0.9])
def test_octree_agrees_with_reference_for_a_target(device, reduction, border):
    for make in (sphere, wavy_sheet, lambda: terrain(30)):
        passes(cluster(device, make(), target_reduction=reduction, border=border))


def test_every_parent_is_the_sum_of_its_children(device):
    made = cluster(device, wavy_sheet(), levels=5, max_error=0.01, border="none")
    tree = made.read_tree()
    expected = reference.build(wavy_sheet(), 32)
    assert np.array_equal(tree["parents"], expected.parents)
    assert np.array_equal(tree["centres"][:, :3], expected.centres)
    # sums of all levels hold the same area and corners, in float32 and in float64
    for level in range(6):
        rows = slice(made.starts[level], made.starts[level] + made.level_nodes[level])
        area = tree["sums"][rows][:, [0, 3, 5]].astype(float).sum()
        assert area == pytest.approx(made.area, rel=1e-5)
        assert tree["sums"][rows, 15].sum() == 3 * wavy_sheet().triangle_count
        assert tree["sums"][rows, 9] == pytest.approx(expected.c[rows], abs=1e-3 * made.area)
    # and by hand: a quadric about the parent's centre is that of its triangles' corners in any cell below it
    root = expected.A[-1], expected.b[-1], expected.c[-1]
    p = expected.grid.points(wavy_sheet().positions).astype(float)[wavy_sheet().triangles]
    m = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    length = np.linalg.norm(m, axis=1)
    normal = m / length[:, None]
    d = -np.einsum("ni,ni->n", normal, p[:, 0] - expected.centres[-1])
    planes = np.concatenate([normal, d[:, None]], 1)
    Q = np.einsum("n,ni,nj->ij", length / 2, planes, planes)
    assert root[0] == pytest.approx(Q[:3, :3])
    assert root[1] == pytest.approx(Q[:3, 3])
    assert root[2] == pytest.approx(Q[3, 3])


@pytest.mark.parametrize("rule", RULES)
def test_larger_errors_leave_fewer_triangles(device, rule):
    made = [
        cluster(device, wavy_sheet(), levels=6, max_error=e, rule=rule)
        for e in (0.0, 0.001, 0.01, 0.1)
    ]
    counts = [p.counters()["triangles"] for p in made]
    assert counts == sorted(counts, reverse=True)


def cheapest(tree, error, price, cube, box=(2, 2, 2)):
    """What the vertices of a box in a cube cost at the least, by trying everything, and their number."""
    below = np.flatnonzero((tree.parents == cube) & (np.arange(len(tree.parents)) != cube))
    if not len(below):
        return error[cube] + price
    side = tree.centres[below] > tree.centres[cube]
    inside = below[[all(d in (2, s) for d, s in zip(box, at, strict=True)) for at in side]]
    if len(inside) < 2:
        return sum(cheapest(tree, error, price, child) for child in inside)
    if box == (2, 2, 2):
        one = error[cube] + price
    else:
        rows = np.zeros(len(inside), int)
        one = reference_boxes.solved(tree, np.array([cube]), inside, rows)[1][0] + price
    ways = [one]
    for axis in range(3):
        if box[axis] == 2:
            halves = [(*box[:axis], half, *box[axis + 1 :]) for half in (0, 1)]
            ways.append(sum(cheapest(tree, error, price, cube, half) for half in halves))
    return min(ways)


@pytest.mark.parametrize("make", [lambda: sphere(8, 12), lambda: wavy_sheet(9)])
def test_reference_joins_at_the_least_cost(make):
    tree = reference.build(make(), 3)  # the last cells are cut
    error = reference.errors(tree, make(), "total")
    for limit in (0.03, 0.3):
        joins, cost = reference_boxes.choose(tree, error, limit, "total")
        assert cost == pytest.approx(cheapest(tree, error**2, limit**2, len(error) - 1))
        # and that is what its vertices do cost
        cells = reference_boxes.cells_of(tree, joins)
        used = np.unique(reference_boxes.cut(tree, joins))
        assert cost == pytest.approx((cells.energies[used] + limit**2).sum())
        assert cost <= reference_boxes.choose(tree, error, limit, "total", boxed=False)[1] + 1e-12


def test_maximum_rule_bounds_the_distance_to_every_plane(device):
    mesh, error = wavy_sheet(), 0.004
    made = cluster(device, mesh, levels=6, max_error=error)
    assert made.params.measured == "maximum"
    (result,) = made.result()
    owner = made.vertex_map()[mesh.triangles]
    p = mesh.positions.astype(float)[mesh.triangles]
    m = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    normal = m / np.linalg.norm(m, axis=1)[:, None]
    # in cells of more than one vertex; the finest ones are as good as it gets
    counts = np.bincount(made.vertex_map()[made.vertex_map() != NO_VERTEX])
    leaves = made.counters()["used_level_6"]
    assert leaves < result.vertex_count / 4
    far = []
    for k in range(3):
        kept = owner[:, k] != NO_VERTEX
        x = result.positions[owner[kept, k]]
        far.append(np.abs(np.einsum("ni,ni->n", normal[kept], x - p[kept, 0])))
    assert np.quantile(np.concatenate(far), 0.9) <= error * mesh.diagonal
    assert counts.max() > 4


def test_flat_parts_get_few_cells_and_creases_keep_theirs(device):
    mesh = cube(24)
    made = cluster(device, mesh, max_error=1e-3)
    (result,) = made.result()
    assert result.triangle_count <= 12
    assert np.isin(np.round(result.positions, 2), (0, 1)).all()


@pytest.mark.parametrize("reduction", [0.5, 0.75, 0.9])
@pytest.mark.parametrize("make", [lambda: sphere(40, 60), lambda: wavy_sheet(60)])
def test_octree_meets_its_target(device, make, reduction):
    result = simplify_to(device, make(), target_reduction=reduction)
    target = result.counters["target"]
    assert 0.9 * target <= result.mesh.triangle_count <= target
    assert result.counters["target_gap"] == target - result.mesh.triangle_count
    assert result.vertex_map.shape == (make().vertex_count,)


def test_vertex_map_of_a_call_is_that_of_its_frame(device):
    mesh = sphere(40, 60)
    result = simplify_to(device, mesh, max_error=5e-3)
    made = cluster(device, mesh, max_error=5e-3)
    assert np.array_equal(result.vertex_map, made.vertex_map())
    assert np.isin(np.arange(result.mesh.vertex_count), result.vertex_map).all()


def test_octree_of_all_triangles_is_the_mesh_itself(device):
    result = simplify_to(device, sphere(), target_count=10_000)
    assert np.array_equal(result.mesh.triangles, sphere().triangles)


@pytest.mark.parametrize("rule", RULES)
def test_closed_input_has_no_open_edge_in_any_cut(device, rule):
    mesh = sphere(40, 60)
    for reduction in (0.6, 0.8, 0.95):
        result = simplify_to(device, mesh, target_reduction=reduction, rule=rule).mesh
        assert result.triangle_count
        assert not open_edges(result).any()


def test_octree_is_nearer_than_a_grid_where_much_is_flat(device):
    # a plate with a fine wave in one corner
    mesh = flat_lattice(60)
    p = mesh.positions.astype(float) / 60
    p[:, 2] = 0.03 * np.sin(30 * p[:, 0]) * np.exp(-20 * (p[:, 0] ** 2 + p[:, 1] ** 2))
    mesh = TriangleMesh(p, mesh.triangles)
    inside = np.abs(p[:, :2] - 0.5).max(1) < 0.4
    assert inside.any()
    octree = simplify_to(device, mesh, target_reduction=0.9).mesh
    grid = simplify_on_grid(device, mesh, target_count=octree.triangle_count).mesh
    rms = [measure(mesh, m, samples=5000)["rms_error_back"] for m in (octree, grid)]
    assert rms[0] <= rms[1]


@pytest.mark.parametrize("rule", RULES)
def test_octree_repeats_its_bytes(device, rule):
    params = {"levels": 5, "max_error": 0.005, "rule": rule}
    expected = outcome(cluster(device, wavy_sheet(), **params))
    for options in ({}, {"local_size": 1}, {"local_size": 48}, {"one_core": True}):
        other = Device.open(**options)
        prepared = cluster(other, wavy_sheet(), **params)
        assert outcome(prepared) == expected, options
        run(other, prepared)
        assert outcome(prepared) == expected, options


@pytest.mark.parametrize(
    ("scale", "offset"), [(1e-30, 0), (1e30, 0), (3e38, 0), (1e-41, 0), (1e-3, 100), (1e20, -3e22)]
)
def test_octree_at_any_scale_is_finite_and_right(device, scale, offset):
    mesh = sphere()
    mesh = TriangleMesh(mesh.positions.astype(np.float64) * scale + offset, mesh.triangles)
    for params in ({"max_error": 0.01}, {"target_reduction": 0.5}):
        prepared = cluster(device, mesh, **params)
        assert np.isfinite(prepared.result()[0].positions).all()
        passes(prepared)


def nasty():
    ball = sphere()
    flips = ball.triangles.copy()
    flips[::7] = flips[::7, ::-1]
    return {
        "empty": EMPTY,
        "points": TriangleMesh(np.ones((5, 3)), EMPTY.triangles),
        "no area": TriangleMesh(np.ones((5, 3)), [[0, 1, 2], [2, 3, 4]]),
        "line": TriangleMesh([[0, 0, 0], [1, 0, 0], [2, 0, 0], [4, 0, 0]], [[0, 1, 2], [1, 2, 3]]),
        "thin": TriangleMesh(
            [[0, 0, 0], [0, 9, 0], [0, 0, 9], [1e-39, 9, 9]], [[0, 1, 2], [1, 3, 2]]
        ),
        "repeated corner": TriangleMesh(ball.positions, [[0, 1, 1], [1, 2, 3]]),
        "duplicates": TriangleMesh(ball.positions, np.repeat(ball.triangles, 2, axis=0)),
        "fin": TriangleMesh(
            [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]],
            [[0, 1, 2], [1, 0, 3], [0, 1, 4]],
        ),
        "flips": TriangleMesh(ball.positions, flips),
        "soup": TriangleMesh(
            ball.positions[ball.triangles].reshape(-1, 3),
            np.arange(3 * ball.triangle_count).reshape(-1, 3),
        ),
    }


@pytest.mark.parametrize("name", nasty())
def test_octree_survives_odd_meshes(device, name):
    mesh = nasty()[name]
    for params in (
        {"max_error": 0.01}, {"target_reduction": 0.5}, {"levels": 9, "max_error": 0.0}
    ):  # fmt: skip
        prepared = cluster(device, mesh, **params)
        passes(prepared)
        assert len(prepared.vertex_map()) == mesh.vertex_count


@pytest.mark.parametrize("levels", [None, 4])
def test_octree_without_duplicates_meets_its_target_and_has_none(device, levels):
    ball = sphere()
    mesh = TriangleMesh(ball.positions, np.repeat(ball.triangles, 2, axis=0))
    params = {"target_count": 60, "levels": levels}
    plain = cluster(device, mesh, **params)
    assert plain.counters()["duplicate_triangles"] >= plain.counters()["triangles"] / 2
    made = cluster(device, mesh, **params, remove_duplicates=True)
    passes(made)
    assert made.counters()["duplicate_triangles"] == 0
    assert 50 <= made.counters()["triangles"] <= 60
    assert plain.counters()["triangles"] <= 60


def test_border_quadrics_bring_the_octree_nearer(device):
    mesh = terrain(50)
    errors = {}
    for border in ("none", "quadrics", "keep"):
        made = cluster(device, mesh, target_reduction=0.9, border=border)
        errors[border] = measure(mesh, made.result()[0], samples=5000)["rms_error"]
    assert errors["quadrics"] < 0.9 * errors["none"]


def test_kept_border_vertices_come_back_last_and_as_they_were(device):
    mesh = terrain(30)
    made = cluster(device, mesh, target_reduction=0.6, border="keep")
    border = np.unique(made.border[:, :2])
    (result,) = made.result()
    own = made.vertex_map()[border]
    assert np.array_equal(own, result.vertex_count - len(border) + np.arange(len(border)))
    assert np.array_equal(result.positions[own], mesh.positions[border])


def test_boxes_bring_the_octree_nearer_than_cubes(device):
    p = flat_lattice(60).positions.astype(float) / 60
    p[:, 2] = 0.2 * np.sin(6 * p[:, 0])  # bends one way
    mesh = TriangleMesh(p, flat_lattice(60).triangles)
    errors = {}
    for shape in ("boxes", "cubes"):
        made = cluster(device, mesh, target_reduction=0.9, shape=shape)
        errors[shape] = measure(mesh, made.result()[0], samples=5000)["rms_error"]
        assert (made.counters()["used_boxes"] > 0) == (shape == "boxes")
    assert errors["boxes"] < 0.7 * errors["cubes"]


def test_octree_gives_memory_back(device):
    before = device.used_bytes
    prepared = cluster(device, sphere(), levels=4, max_error=0.01)
    assert device.used_bytes > before
    del prepared
    assert device.used_bytes == before


def test_octree_counts_its_levels(device):
    counters = cluster(device, sphere(), levels=4, max_error=0.03).counters()
    assert counters["levels"] == 4
    assert sum(counters[f"used_level_{n}"] for n in range(5)) == counters["vertices"]
    assert counters["threshold"] == pytest.approx(0.03)


@pytest.mark.parametrize(
    ("params", "text"),
    [
        ({"max_error": 0.1, "target_count": 5}, "target_reduction, target_count, max_error: expected one"),
        ({"max_error": -1}, "max_error: expected at least 0, got -1"),
        ({"levels": 10}, "levels: expected 1 to 9, got 10"),
        ({"rule": "other"}, "rule: expected one of total, rms, maximum"),
    ],
)  # fmt: skip
def test_octree_params_refuse_what_does_not_fit(params, text):
    with pytest.raises(ValueError, match=text):
        Params(**params)


def test_find_limit_halves_to_the_target():
    thresholds = np.sort(np.random.default_rng(0).uniform(0, 3, 1000)).astype(np.float32)

    def count(limit):
        return int((thresholds > limit).sum())

    limit, left, _ = find_limit(count, 400, 3.0)
    assert count(limit) == left
    assert 380 <= left <= 400
    assert find_limit(count, 2000, 3.0) == (-1, 1000, 1)
