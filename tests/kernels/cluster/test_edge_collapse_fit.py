"""The last step of edge collapse: vertices that are fitted to the input."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.measure.quality import measure
from lodbench.kernels.cluster.edge_collapse import Params, collapses, fit_reference, replay
from lodbench.kernels.cluster.edge_collapse import simplify as edge_collapse
from lodbench.kernels.cluster.edge_collapse.prepare import prepare
from lodbench.kernels.opencl.device import Device
from lodbench.kernels.stages import scan
from lodbench.kernels.system import run
from tests.kernels.cluster.meshes import sphere, wavy_sheet
from tests.kernels.cluster.test_edge_collapse import noisy, torus, unit_normals

FORMS = ["blocks", "rounds"]


def both(device, mesh, **options):
    """Fitted, and as the collapses left it."""
    return [edge_collapse(device, mesh, fit=fit, **options) for fit in (True, False)]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("make", [torus, wavy_sheet, lambda: noisy(sphere(40, 60), 3, 0.004)])
def test_same_triangles_nearer_to_the_input(device, make, form):
    mesh = make()
    fitted, plain = both(device, mesh, target_reduction=0.9, form=form, block=200)
    assert np.array_equal(fitted.mesh.triangles, plain.mesh.triangles)
    assert np.array_equal(fitted.vertex_map, plain.vertex_map)
    rms = [measure(mesh, r.mesh, samples=20_000)["rms_error"] for r in (fitted, plain)]
    assert rms[0] < 0.97 * rms[1]


@pytest.mark.parametrize("make", [torus, wavy_sheet, lambda: noisy(icosphere(3), 3, 0.1)])
@pytest.mark.parametrize("share", [0.3, 0.05])
def test_moves_as_the_reference_does(device, make, share):
    mesh = make()
    lock = mesh.positions[:, 0] > np.quantile(mesh.positions[:, 0], 0.98)
    options = {"target_count": round(share * mesh.triangle_count), "lock": lock}
    fitted, plain = both(device, mesh, **options)
    locked = np.zeros(plain.mesh.vertex_count, bool)
    locked[plain.vertex_map[lock]] = True
    expected = fit_reference.fit(mesh, plain.mesh, plain.vertex_map, locked, Params().crease_cosine)
    moved = np.linalg.norm(expected - plain.mesh.positions, axis=1)
    assert moved.max() > 0
    # a sample as near to one triangle as to the other may count for either
    off = np.linalg.norm(expected - fitted.mesh.positions, axis=1)
    assert np.quantile(off, 0.9) < 1e-4 * mesh.diagonal
    assert off.max() < max(moved.max(), 1e-5 * mesh.diagonal)


def test_borders_creases_and_locked_vertices_stay_to_the_bit(device):
    mesh = wavy_sheet()
    lock = mesh.positions[:, 1] > 0.9
    fitted, plain = both(device, mesh, target_reduction=0.8, lock=lock, block=200)
    same = (fitted.mesh.positions == plain.mesh.positions).all(axis=1)
    edges = np.sort(plain.mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    ends, uses = np.unique(edges, axis=0, return_counts=True)
    assert same[ends[uses == 1]].all()
    assert same[plain.vertex_map[lock]].all()
    assert not same.all()
    for angle, least in ((None, False), (0.0, True)):
        fitted, plain = both(device, noisy(torus(), 1), target_reduction=0.8, crease_angle=angle)
        assert np.array_equal(fitted.mesh.positions, plain.mesh.positions) == least


@settings(max_examples=20, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    target=st.integers(4, 150),
    amount=st.sampled_from([0.02, 0.3, 1.0]),
)
def test_no_triangle_turns_over_and_nothing_else_changes(device, seed, target, amount):
    mesh = noisy(icosphere(2) if seed % 2 else wavy_sheet(12), seed, amount)
    fitted, plain = both(device, mesh, target_count=target, block=40)
    assert np.array_equal(fitted.mesh.triangles, plain.mesh.triangles)
    assert np.isfinite(fitted.mesh.positions).all()
    rows = plain.mesh.triangles
    before, after = (
        unit_normals(m.positions.astype(float), rows) for m in (plain.mesh, fitted.mesh)
    )
    # each of two steps turns a triangle by less than a right angle
    assert not ((before * after).sum(1) < -0.5).any()


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 10_000), fit=st.booleans(), share=st.sampled_from([0.1, 0.3, 0.7]))
def test_the_last_level_of_a_replay_is_the_fitted_one_and_those_before_are_not(
    device, seed, fit, share
):
    mesh = noisy(icosphere(2), seed, 0.1)
    options = {"target_count": round(share * mesh.triangle_count), "fit": fit, "block": 60}
    made = collapses(device, mesh, **options)
    direct = edge_collapse(device, mesh, **options).mesh
    last = replay(made, direct.triangle_count)
    assert np.array_equal(last.positions, direct.positions)
    assert (made.fitted is not None) == fit
    plain = collapses(device, mesh, **{**options, "fit": False})
    for count in (direct.triangle_count + 2, direct.triangle_count + 30):
        levels = [replay(m, count) for m in (made, plain)]
        assert np.array_equal(levels[0].positions, levels[1].positions)
        assert np.array_equal(levels[0].triangles, levels[1].triangles)


@pytest.mark.parametrize("form", FORMS)
def test_any_number_of_chunks_and_cores_gives_the_same_bytes(device, monkeypatch, form):
    mesh = noisy(sphere(60, 80), 4, 0.01)

    def outcome(on):
        result = edge_collapse(on, mesh, target_reduction=0.9, form=form, block=300)
        return result.mesh.positions.tobytes(), result.vertex_map.tobytes()

    expected = outcome(device)
    for given_ in ({"local_size": 1}, {"one_core": True}):
        assert outcome(Device.open(**given_)) == expected, given_
    for rows in (64, 700):
        monkeypatch.setattr(scan, "CHUNK_ROWS", rows)
        assert outcome(device) == expected, rows


def test_items_that_share_a_map_give_the_same_every_time(device, monkeypatch):
    # as a GPU's do
    monkeypatch.setattr("lodbench.kernels.cluster.edge_collapse.fit.map_count", lambda *_: (1, 5))
    mesh = noisy(sphere(60, 80), 4, 0.01)
    found = [edge_collapse(device, mesh, target_reduction=0.9).mesh for _ in range(4)]
    assert len({mesh.positions.tobytes() for mesh in found}) == 1
    monkeypatch.undo()
    usual = edge_collapse(device, mesh, target_reduction=0.9).mesh
    rms = [measure(mesh, result, samples=20_000)["rms_error"] for result in (usual, found[0])]
    assert rms[1] == pytest.approx(rms[0], rel=0.05), "other samples of a vertex come first"


@pytest.mark.parametrize("bound", [0.01, 0.003])
def test_a_bound_is_held_by_what_is_fitted(device, bound):
    mesh = noisy(torus(), 1, 0.002)
    result = edge_collapse(device, mesh, max_error=bound).mesh
    assert result.triangle_count < mesh.triangle_count
    assert measure(mesh, result, samples=20_000)["max_error"] <= bound


def test_more_triangles_than_there_is_room_for_are_left_where_they_are(device):
    # parts that share nothing cannot go below four triangles each
    ball = icosphere(1)
    count = ball.vertex_count
    mesh = TriangleMesh(
        np.concatenate([ball.positions + np.float32([3 * k, 0, 0]) for k in range(20)]),
        np.concatenate([ball.triangles + k * count for k in range(20)]),
    )
    fitted, plain = both(device, mesh, target_count=10)
    assert plain.mesh.triangle_count == 80
    assert np.array_equal(fitted.mesh.positions, plain.mesh.positions)


def test_frames_are_alike(device):
    prepared = prepare(device, torus(), Params(target_reduction=0.9))
    found = []
    for _ in range(3):
        run(device, prepared)
        found.append(prepared.result()[0].positions.tobytes())
    assert len(set(found)) == 1
