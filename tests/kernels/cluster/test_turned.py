import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import displaced_icosphere, terrain, torus
from lodbench.kernels import simplify_mesh
from lodbench.kernels.cluster import turned
from lodbench.kernels.cluster.quadric_clustering import Params, prepare
from lodbench.kernels.system import run
from tests.kernels.cluster.meshes import wavy_sheet

METHODS = ("quadric_clustering", "vertex_average")


def normals(points):
    points = points.astype(float)
    return np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])


def by_hand(mesh, result):
    """(duplicates, turned over) of a result whose duplicates were left in."""
    out = result.mesh
    sets = [frozenset(t) for t in out.triangles.tolist()]
    corners = result.vertex_map[mesh.triangles].astype(np.int64)
    a, b, c = corners.T
    source = (a != b) & (b != c) & (c != a)
    assert np.array_equal(corners[source], out.triangles)
    before, after = (
        normals(mesh.positions[mesh.triangles[source]]),
        normals(out.positions[out.triangles]),
    )
    return len(sets) - len(set(sets)), int(((before * after).sum(1) < 0).sum())


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "mesh", [torus(60, 30).bare(), terrain(60).bare(), displaced_icosphere(16).bare(), wavy_sheet()]
)
def test_counts_are_those_told_by_hand(device, mesh, method):
    for cells in (4, 9, 30):
        result = simplify_mesh(device, mesh, cells=cells, method=method)
        found = result.counters["duplicate_triangles"], result.counters["flipped_triangles"]
        expected = by_hand(mesh, result)
        assert found[0] == expected[0]
        assert abs(found[1] - expected[1]) <= 2, "float32 in units of a cell may see 0 otherwise"


@pytest.mark.parametrize("distinct", [False, True])
@pytest.mark.parametrize("method", METHODS)
def test_turned_triangles_go_where_asked_with_their_vertices(device, method, distinct):
    mesh = displaced_icosphere(48)
    options = {"cells": 23, "method": method, "remove_duplicates": distinct}
    before = simplify_mesh(device, mesh, **options)
    assert before.counters["flipped_triangles"] > 0
    after = simplify_mesh(device, mesh, **options, remove_flipped=True)
    assert after.counters["flipped_triangles"] == 0
    gone = before.mesh.triangle_count - after.mesh.triangle_count
    assert gone == after.counters["flipped_removed"] <= before.counters["flipped_triangles"]
    assert after.counters["triangles"] == after.mesh.triangle_count
    assert set(np.unique(after.mesh.triangles)) == set(range(after.mesh.vertex_count))
    own = after.vertex_map != turned.NO_VERTEX
    places = before.mesh.positions[before.vertex_map[own]]
    assert after.mesh.positions[after.vertex_map[own]].tobytes() == places.tobytes()
    assert after.mesh.normals is not None
    if distinct:
        assert turned.duplicates(after.mesh.triangles, after.mesh.vertex_count) == 0
        # of two with the same corners the one that is right stays, whichever came first
        every = simplify_mesh(device, mesh, cells=23, method=method, remove_flipped=True)
        sets = {
            frozenset(map(tuple, p)) for p in every.mesh.positions[every.mesh.triangles].tolist()
        }
        assert len(sets) == after.mesh.triangle_count


def test_a_target_counts_what_is_left(device):
    asked = {"target_reduction": 0.9, "remove_flipped": True}
    result = simplify_mesh(device, torus(90, 50), **asked)
    counters = result.counters
    assert counters["target_gap"] == counters["target"] - result.mesh.triangle_count


def test_the_mesh_as_it_came_is_counted_too(device):
    mesh = torus(8, 6).bare()
    twice = TriangleMesh(mesh.positions, np.concatenate([mesh.triangles, mesh.triangles[:5, ::-1]]))
    counters = simplify_mesh(device, twice, target_reduction=0.0).counters
    assert (counters["duplicate_triangles"], counters["flipped_triangles"]) == (5, 0)


@given(st.integers(0, 2**32 - 1), st.integers(0, 60), st.sampled_from([4, 9, 3_000_000, 2**32 - 1]))
def test_first_of_each_is_what_a_set_keeps(seed, count, vertex_count):
    random = np.random.default_rng(seed)
    triangles = random.integers(max(0, vertex_count - 5), vertex_count, (count, 3)).astype(
        np.uint32
    )
    seen, expected = set(), []
    for row, triangle in enumerate(triangles.tolist()):
        key = tuple(sorted(triangle))
        if key not in seen:
            expected.append(row)
        seen.add(key)
    assert turned.first_of_each(triangles, vertex_count).tolist() == expected
    assert turned.duplicates(triangles, vertex_count) == count - len(expected)


def test_idle_triangles_are_counted_when_they_are_asked_for(device, monkeypatch):
    asked = []
    count = turned.counted
    monkeypatch.setattr(turned, "counted", lambda *given: asked.append(1) or count(*given))
    counters = simplify_mesh(device, torus(60, 30).bare(), cells=9).counters
    assert set(turned.COUNTED) < set(counters)
    assert counters["triangles"] > 0 and not asked
    prepared = prepare(device, torus(60, 30), Params(9))
    run(device, prepared)
    assert dict(prepared.counters()).items() <= dict(counters).items()
    assert len(counters) == len(dict(counters))
    assert asked == [1, 1], "once for all of them, and once of a system's own"
