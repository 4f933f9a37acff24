"""Clustering and then edge collapse: the surface stays what it was, the target is met, and all maps lead there."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import displaced_icosphere, icosphere, terrain, torus
from lodbench.harness.measure.quality import topology
from lodbench.kernels import simplify_mesh
from lodbench.kernels.cluster.hybrid import Hybrid, Params, reference
from lodbench.kernels.cluster.hybrid.joined import joined
from lodbench.kernels.cluster.turned import NO_VERTEX
from lodbench.kernels.opencl.device import Device
from lodbench.kernels.system import run
from tests.kernels.cluster.meshes import cube, flat_lattice, single_triangle, tetrahedron

KEPT = ("components", "euler", "open_edges")
SOUND = ("nonmanifold_edges", "flipped_edges", "duplicate_triangles")
EMPTY = TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int))


def shell():
    """A hollow ball, thinner than the cells of coarse grids."""
    outer = icosphere(4).bare()
    inside = outer.triangles[:, ::-1] + outer.vertex_count
    return TriangleMesh(
        np.concatenate([outer.positions, 0.97 * outer.positions]),
        np.concatenate([outer.triangles, inside]),
    )


def crumbs():
    """A ball with some far smaller ones in it, each within a cell."""
    big, small = icosphere(4).bare(), icosphere(1).bare()
    points, faces, at = [big.positions], [big.triangles], big.vertex_count
    for k in range(5):
        points.append(small.positions * 0.01 + np.float32(0.1 * k))
        faces.append(small.triangles + at)
        at += small.vertex_count
    return TriangleMesh(np.concatenate(points), np.concatenate(faces))


CLOSED = {
    "torus": torus(90, 40).bare(), "displaced": displaced_icosphere(30).bare(), "shell": shell(),
    "crumbs": crumbs(), "thin torus": torus(160, 12).bare(),
}  # fmt: skip


@pytest.mark.parametrize("name", CLOSED)
@pytest.mark.parametrize("first", ["grid", "octree"])
def test_closed_surfaces_keep_components_and_genus_and_meet_the_target(device, name, first):
    mesh = CLOSED[name]
    before = topology(mesh)
    for reduction in (0.9, 0.96):
        result = simplify_mesh(
            device, mesh, target_reduction=reduction, method="hybrid", first=first, factor=2.0
        )
        after = topology(result.mesh)
        assert {key: after[key] for key in KEPT} == {key: before[key] for key in KEPT}
        assert not any(after[key] for key in SOUND)
        assert 0 <= result.counters["target_gap"] <= 1
        assert result.counters["first_triangles"] < mesh.triangle_count


def test_borders_stay_and_map_and_sources_lead_over_both_stages(device):
    mesh = terrain(60).bare()
    prepared = Hybrid(device, mesh, Params(target_reduction=0.9))
    run(device, prepared)
    (result,) = prepared.result()
    mapped = prepared.vertex_map()[mesh.triangles[prepared.sources()]]
    assert np.array_equal(mapped, result.triangles)
    before, after = topology(mesh), topology(result)
    assert after["euler"] == before["euler"]
    assert after["components"] == before["components"]
    assert not any(after[key] for key in SOUND)
    kept = simplify_mesh(
        device, mesh, target_reduction=0.8, method="hybrid", factor=2.0, preserve_border=True
    )
    assert topology(kept.mesh)["open_edges"] == before["open_edges"]


def test_attributes_come_along(device):
    mesh = terrain(50)
    result = simplify_mesh(device, mesh, target_reduction=0.9, method="hybrid")
    whole = simplify_mesh(device, mesh, target_reduction=0.9, method="edge_collapse")
    for name in ("normals", "uvs"):
        ours, theirs = getattr(result.mesh, name), getattr(whole.mesh, name)
        assert (ours is None) == (theirs is None)
        assert ours is None or len(ours) == result.mesh.vertex_count


def test_locked_vertices_stay_where_they_are(device):
    mesh = displaced_icosphere(20).bare()
    lock = np.zeros(mesh.vertex_count, bool)
    lock[::97] = True
    result = simplify_mesh(
        device, mesh, target_reduction=0.8, method="hybrid", factor=2.0, lock=lock
    )
    assert result.vertex_map is not None
    assert np.array_equal(result.mesh.positions[result.vertex_map[lock]], mesh.positions[lock])
    found = topology(result.mesh)
    assert found["euler"] == topology(mesh)["euler"] and not any(found[key] for key in SOUND)
    with pytest.raises(ValueError, match="lock: expected booleans"):
        simplify_mesh(device, mesh, target_count=9, method="hybrid", lock=lock[:3])


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 30), st.integers(0, 3))
def test_any_joining_of_vertices_ends_as_the_reference_says(device, seed, cells, kind):
    """Vertices thrown together at random, some left out: far worse than any grid does."""
    mesh = (torus(9, 6), icosphere(1), displaced_icosphere(4), terrain(6))[kind].bare()
    random = np.random.default_rng(seed)
    numbers = (
        np.unique(random.integers(0, cells, mesh.vertex_count), return_inverse=True)[1]
        .reshape(-1)
        .astype(np.uint32)
    )
    numbers[random.random(mesh.vertex_count) < 0.1] = NO_VERTEX
    there = numbers != NO_VERTEX
    numbers[there] = np.unique(numbers[there], return_inverse=True)[1].reshape(-1)
    # a clustering gives vertices that triangles use
    labels = numbers.astype(np.int64)
    labels[~there] = -1 - np.arange(np.count_nonzero(~there))
    count = int(numbers[there].max()) + 1 if there.any() else 0
    rows, left = reference.left(mesh, np.where(there, labels, -1))
    clustered = TriangleMesh(
        random.random((count, 3)), left[(left >= 0).all(axis=1)].reshape(-1, 3)
    )
    given = device.upload("triangles", mesh.triangles, np.uint32)
    made = joined(device, given, mesh.positions, clustered, numbers)
    found = reference.labels(mesh, reference.groups(mesh, numbers))
    rows, left = reference.left(mesh, found)
    assert np.array_equal(made.sources, rows)
    # vertices are the same ones, by whatever numbers
    pairs = np.unique(np.stack([made.mesh.triangles.ravel(), left.ravel()]), axis=1)
    assert pairs.shape[1] == len(np.unique(left)) == made.mesh.vertex_count
    assert made.surface


def test_a_first_stage_that_changes_the_surface_is_done_anew_and_then_left_out(device, monkeypatch):
    mesh = displaced_icosphere(20).bare()
    monkeypatch.setattr(Hybrid, "_same", lambda *_: False)
    result = simplify_mesh(device, mesh, target_reduction=0.95, method="hybrid")
    whole = simplify_mesh(device, mesh, target_reduction=0.95, method="edge_collapse")
    assert result.counters["first_tries"] > 1
    assert result.counters["first_triangles"] == mesh.triangle_count
    assert np.array_equal(result.mesh.positions, whole.mesh.positions)


def test_the_same_bytes_on_one_core():
    mesh = displaced_icosphere(30).bare()
    bytes_ = set()
    for options in ({}, {"one_core": True}, {"local_size": 48}):
        result = simplify_mesh(Device.open(**options), mesh, target_reduction=0.9, method="hybrid")
        assert result.vertex_map is not None
        bytes_.add(
            result.mesh.positions.tobytes()
            + result.mesh.triangles.tobytes()
            + result.vertex_map.tobytes()
        )
    assert len(bytes_) == 1


@pytest.mark.parametrize("scale", [1e-30, 1.0, 1e30])
@pytest.mark.parametrize(
    "mesh", [EMPTY, single_triangle(), tetrahedron(), cube(), flat_lattice(6), icosphere(2).bare()]
)
def test_any_mesh_passes_through(device, mesh, scale):
    mesh = TriangleMesh((mesh.positions * scale).astype(np.float32), mesh.triangles)
    for options in ({"target_reduction": 0.7}, {"target_count": 1}, {"target_reduction": 0.0}):
        result = simplify_mesh(device, mesh, method="hybrid", factor=1.1, **options)
        assert np.isfinite(result.mesh.positions).all()
        assert result.mesh.triangle_count <= mesh.triangle_count


def test_all_triangles_are_the_mesh_as_it_came(device):
    mesh = dataclasses.replace(terrain(5))
    result = simplify_mesh(device, mesh, target_reduction=0.0, method="hybrid")
    assert result.mesh is mesh
    assert result.counters["target_gap"] == 0
