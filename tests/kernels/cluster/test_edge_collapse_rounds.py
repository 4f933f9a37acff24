import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.measure.quality import measure, topology
from lodbench.kernels.cluster.edge_collapse import (
    Params,
    collapses,
    reference,
    replay,
    rounds,
    rounds_reference,
    simplify,
)
from lodbench.kernels.cluster.edge_collapse.prepare import prepare
from lodbench.kernels.opencl.device import Device
from lodbench.kernels.stages import scan
from lodbench.kernels.system import run
from tests.kernels.cluster.meshes import flat_lattice, single_triangle, sphere, wavy_sheet
from tests.kernels.cluster.test_edge_collapse import (
    EMPTY,
    apart,
    assert_manifold,
    nasty,
    noisy,
    outcome,
    tent,
    torus,
)

ROUNDS = {"form": "rounds"}
THRESHOLD, STUBBORN = 6, 7  # words of the state


def recorded(device, mesh, limit=rounds.MOST, **options):
    """A subject that has run, with its collapses as (round, pass, from, to, place) in the units of the mesh."""
    prepared = prepare(device, mesh, Params(**ROUNDS, **options), recorded=True)
    prepared.most_rounds = limit
    run(device, prepared)
    parents, keys, moves = (
        device.read(b) for b in (prepared.parents, prepared.sequence, prepared.moves)
    )
    gone = np.flatnonzero(parents != np.arange(len(parents)))
    found = [
        (*keys[u, :2].tolist(), u, int(parents[u]), moves[u, :3] * prepared.unscale)
        for u in gone[np.lexsort(keys[gone].T[::-1])].tolist()
    ]
    return prepared, found


@pytest.mark.parametrize("make", [lambda: noisy(icosphere(3), 7), lambda: noisy(wavy_sheet(20), 8)])
@pytest.mark.parametrize("options", [{}, {"preserve_border": True}, {"crease_angle": 20.0}])
def test_one_round_is_that_of_the_reference(device, make, options):
    mesh = make()
    prepared, found = recorded(device, mesh, limit=1, target_count=1, **options)
    surface = reference.Surface(mesh, prepared.params)
    threshold = device.read(prepared.state)[THRESHOLD : THRESHOLD + 1].view(np.float32)[0]
    scale = surface.scale * prepared.unscale  # costs are areas times squares of lengths
    expected = rounds_reference.one_round(surface, float(threshold) * scale**4, rounds.PASSES)
    assert sum(map(len, expected)) > 15
    for number, collapse in enumerate(expected):
        own = {(u, v): place for _, p, u, v, place in found if p == number}
        assert own.keys() == {(u, v) for u, v, _ in collapse}
        for u, v, place in collapse:
            assert own[u, v] == pytest.approx(place / surface.scale, abs=2e-4 * mesh.diagonal)


def normals(points, rows):
    a, b, c = (points[rows[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


@settings(max_examples=12, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    make=st.sampled_from([lambda: icosphere(2), lambda: torus(8, 12), lambda: wavy_sheet(9)]),
)
def test_collapses_of_a_round_are_apart_keep_the_surface_and_turn_no_triangle(device, seed, make):
    mesh = noisy(make(), seed, 0.2)
    prepared, found = recorded(device, mesh, target_count=20)
    points, rows = mesh.positions.astype(np.float64), mesh.triangles.copy()
    limit = np.cos(np.radians(prepared.params.normal_limit))
    stubborn = device.read(prepared.state)[STUBBORN]
    assert found
    for number in sorted({f[0] for f in found}):
        here = [f for f in found if f[0] == number]
        owner = {}
        for _, _, u, v, _ in here:
            assert u not in owner and v not in owner
            owner[u] = owner[v] = (u, v)
        for row in rows.tolist():
            assert len({owner[w] for w in row if w in owner}) <= 1, "two collapses at a triangle"
        border = rim(rows)
        before = points.copy()
        for _, _, u, v, place in here:
            at = [set(rows[(rows == w).any(axis=1)].ravel().tolist()) - {w} for w in (u, v)]
            both = (rows == u).any(axis=1) & (rows == v).any(axis=1)
            along = u in border and v in border
            assert len(at[0] & at[1]) == both.sum() == (1 if along else 2)
            points[v] = place
        after = rows.copy()
        for _, _, u, v, _ in here:
            after[after == u] = v
        left = [len(set(row)) == 3 for row in after.tolist()]
        n, m = normals(before, rows[left]), normals(points, after[left])
        cosine = (n * m).sum(1)
        lengths = np.linalg.norm(n, axis=1) * np.linalg.norm(m, axis=1)
        least = 0.0 if stubborn and number >= stubborn else limit
        assert (cosine >= (least - 1e-2) * lengths).all()
        rows = after[left]
        assert_manifold(TriangleMesh(points, rows))


def rim(rows):
    """Vertices of edges that one triangle has."""
    ends = np.sort(np.concatenate([rows[:, [0, 1]], rows[:, [1, 2]], rows[:, [2, 0]]]), axis=1)
    edges, uses = np.unique(ends, axis=0, return_counts=True)
    return set(edges[uses == 1].ravel().tolist())


@pytest.mark.parametrize("reduction", [0.3, 0.9, 0.97])
@pytest.mark.parametrize("make", [lambda: sphere(30, 40), torus, lambda: noisy(torus(), 1)])
def test_closed_manifold_stays_closed_manifold_of_its_genus_and_meets_its_target(
    device, make, reduction
):
    mesh = make()
    result = simplify(device, mesh, target_reduction=reduction, **ROUNDS)
    assert_manifold(result.mesh)
    found = topology(result.mesh)
    assert found["open_edges"] == 0
    assert found["euler"] == topology(mesh)["euler"]
    target = result.counters["target"]
    assert result.mesh.triangle_count == target - target % 2


@pytest.mark.parametrize("target", [500, 501, 77])
def test_open_mesh_stays_manifold_with_its_one_border(device, target):
    result = simplify(device, wavy_sheet(), target_count=target, **ROUNDS).mesh
    assert_manifold(result)
    assert topology(result)["euler"] == 1
    assert target - 1 <= result.triangle_count <= target


def test_last_round_takes_the_cheapest(device):
    # of the winners of one round, those with the least costs, to a quarter of an octave
    mesh = noisy(icosphere(3), 5)
    _, every = recorded(device, mesh, limit=1, target_count=1)
    few, found = recorded(device, mesh, limit=1, target_count=mesh.triangle_count - 20)
    assert few.result()[0].triangle_count == mesh.triangle_count - 20
    cost = {u: c for u, c in zip(*costs_of(every, mesh), strict=True)}
    first = {f[2] for f in every if f[1] == 0}
    taken = {f[2] for f in found}
    assert taken <= first and len(taken) == 10
    assert max(cost[u] for u in taken) <= 1.26 * min(cost[u] for u in first - taken)


def costs_of(found, mesh):
    surface = reference.Surface(mesh, Params())
    costs = [reference.merge(surface.quadrics[f[2]], surface.quadrics[f[3]])[0] for f in found]
    return [f[2] for f in found], costs


def test_borders_creases_and_locks_hold(device):
    mesh = wavy_sheet()
    kept = simplify(device, mesh, target_count=700, preserve_border=True, **ROUNDS)
    edge = (np.abs(mesh.positions[:, :2] - 0.5) == 0.5).any(axis=1)
    assert np.array_equal(kept.mesh.positions[kept.vertex_map[edge]], mesh.positions[edge])
    assert kept.mesh.triangle_count == 700
    roof = tent()

    def off(**options):
        result = simplify(
            device, roof, target_count=120, border_weight=10.0, fit=False, **ROUNDS, **options
        )
        ridge = result.vertex_map[np.flatnonzero(roof.positions[:, 0] == 0.5)]
        return np.abs(result.mesh.positions[ridge, 0] - 0.5).mean()

    assert off(crease_angle=10.0) < 0.7 * off()
    ball = sphere(30, 40)
    lock = ball.positions[:, 2] > 0.5
    result = simplify(device, ball, target_count=1400, lock=lock, **ROUNDS)
    assert np.array_equal(result.mesh.positions[result.vertex_map[lock]], ball.positions[lock])
    assert result.mesh.triangle_count == 1400


@pytest.mark.parametrize(
    "mesh", [noisy(sphere(60, 80), 4, 0.01), wavy_sheet(50)], ids=["closed", "open"]
)
def test_any_number_of_chunks_and_cores_gives_the_same_bytes(device, mesh, monkeypatch):
    options = {"target_reduction": 0.9, **ROUNDS}
    expected = outcome(device, mesh, **options)
    assert outcome(device, mesh, **options) == expected
    for given_ in ({"local_size": 1}, {"one_core": True}):
        assert outcome(Device.open(**given_), mesh, **options) == expected, given_
    for size in (64, 700, 10**9):
        monkeypatch.setattr(scan, "CHUNK_ROWS", size)
        assert outcome(device, mesh, **options) == expected, size


@pytest.mark.parametrize("make", [torus, wavy_sheet])
def test_replay_ends_where_simplifying_does_and_every_level_is_manifold(device, make):
    mesh = make()
    made = collapses(device, mesh, target_count=200, **ROUNDS)
    direct = simplify(device, mesh, target_count=200, **ROUNDS).mesh
    last = replay(made, 200)
    assert np.array_equal(last.positions, direct.positions)
    assert np.array_equal(last.triangles, direct.triangles)
    for count in (300, 555, 1500):
        level = replay(made, count)
        assert_manifold(level)
        assert topology(level)["euler"] == topology(mesh)["euler"]
        assert count - 1 <= level.triangle_count <= count


@pytest.mark.parametrize("name", nasty())
def test_nasty_meshes_pass_through(device, name):
    mesh = nasty()[name]
    for options in ({"target_reduction": 0.5}, {"target_count": 1}):
        prepared = prepare(device, mesh, Params(**options, **ROUNDS))
        run(device, prepared)
        (result,) = prepared.result()
        assert np.isfinite(result.positions).all()
        check = prepared.check()
        assert check.passed, f"{check.what}: {check.value}"


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_any_soup_passes_through(device, seed):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 30))
    mesh = TriangleMesh(rng.normal(size=(12, 3)), rng.integers(0, 12, (count, 3)))
    result = simplify(device, mesh, target_reduction=0.7, **ROUNDS).mesh
    assert np.isfinite(result.positions).all()
    rows = result.triangles
    assert rows.size == 0 or rows.max() < result.vertex_count


def test_flat_parts_give_what_they_have_and_do_not_stall(device):
    result = simplify(device, flat_lattice(40), target_count=2, **ROUNDS).mesh
    assert result.triangle_count == 2
    assert simplify(device, single_triangle(), target_count=1, **ROUNDS).mesh.triangle_count == 1
    assert simplify(device, EMPTY, target_count=1, **ROUNDS).mesh.triangle_count == 0


@pytest.mark.parametrize("scale", [1e-30, 1e30])
def test_scale_changes_nothing_but_the_scale(device, scale):
    mesh = sphere(20, 30)
    scaled = TriangleMesh(mesh.positions.astype(np.float64) * scale, mesh.triangles)
    result = simplify(device, scaled, target_reduction=0.8, **ROUNDS).mesh
    assert np.isfinite(result.positions).all()
    shrunk = TriangleMesh(result.positions / np.float32(scale), result.triangles)
    assert measure(mesh, shrunk)["rms_error"] < 0.02


def test_both_forms_are_as_exact(device):
    mesh = noisy(sphere(60, 80), 6, 0.002)
    errors = [
        measure(mesh, simplify(device, mesh, target_reduction=0.9, form=form).mesh, samples=20_000)[
            "rms_error"
        ]
        for form in ("blocks", "rounds")
    ]
    assert errors[1] < 1.1 * errors[0]


def test_form_is_that_of_the_device_where_none_is_asked_for(device):
    assert Params().form_on(cpu=True) == "blocks"
    assert Params().form_on(cpu=False) == "rounds"
    mesh = sphere(30, 40)
    auto, blocks = (outcome(device, mesh, target_count=99, form=f) for f in ("auto", "blocks"))
    assert (auto == blocks) == device.is_cpu
    with pytest.raises(ValueError, match=r"^form: expected one of auto, blocks, rounds, got "):
        simplify(device, mesh, form="serial")


def test_near_meshes_of_either_form(device):
    mesh = noisy(icosphere(3), 3)
    pair = [
        simplify(device, mesh, target_count=1200, form=form).mesh for form in ("blocks", "rounds")
    ]
    assert apart(*pair) < 0.2 * mesh.diagonal


def test_bound_and_weights_of_attributes_count(device):
    mesh = noisy(sphere(40, 60), 2, 0.005)
    result = simplify(device, mesh, max_error=0.01, **ROUNDS)
    assert result.mesh.triangle_count < mesh.triangle_count / 3
    quality = measure(mesh, result.mesh, samples=20_000)
    assert quality["max_error"] <= 0.01  # of the diagonal
    flat = flat_lattice(24)
    red = (flat.positions[:, 0] + flat.positions[:, 1] > 24).astype(np.float32)
    painted = TriangleMesh(flat.positions, flat.triangles, colours=np.stack([red] * 3, 1))

    def off(weight):
        small = simplify(device, painted, target_count=100, colour_weight=weight, **ROUNDS).mesh
        back = np.linalg.norm(flat.positions[:, None] - small.positions[None], axis=2).argmin(1)
        return np.abs(red - small.colours[back, 0]).mean()

    assert off(0.1) < 0.8 * off(0.0)
