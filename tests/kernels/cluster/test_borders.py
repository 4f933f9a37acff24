"""Border edges on the device against counting them, and what holding or keeping them does to a clustering."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, plane, terrain, torus
from lodbench.harness.measure import quality
from lodbench.kernels.cluster.borders import border_vertices
from lodbench.kernels.cluster.quadric_clustering import Params, prepare
from lodbench.kernels.cluster.quadric_clustering.reference import simplify
from lodbench.kernels.cluster.upload import Upload
from lodbench.kernels.system import run

WAYS = {
    "fused": {},
    "separate": {"strategy": "separate"},
    "slabs": {"accumulate": "slabs", "slabs": 5},
    "fixed_point": {"accumulate": "fixed_point"},
}


def counted(triangles):
    """Border edges by a dictionary, in input order."""
    edges = [(a, b, c) for t in triangles.tolist() for a, b, c in (t, t[1:] + t[:1], t[2:] + t[:2])]
    uses = Counter(frozenset(edge[:2]) for edge in edges)
    return [edge for edge in edges if edge[0] != edge[1] and uses[frozenset(edge[:2])] == 1]


def found(device, triangles, vertices=None):
    count = int(triangles.max(initial=0)) + 1 if vertices is None else vertices
    mesh = TriangleMesh(np.arange(3.0 * count).reshape(-1, 3), triangles)
    return [tuple(edge) for edge in Upload(device, mesh).border_edges.tolist()]


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(*[st.integers(0, 7)] * 3), max_size=20))
def test_border_edges_are_those_with_one_use(device, triangles):
    triangles = np.array(triangles, np.uint32).reshape(-1, 3)
    assert found(device, triangles, 8) == counted(triangles)


@pytest.mark.parametrize("make", [lambda: icosphere(3), lambda: torus(40, 30)])
def test_closed_mesh_has_none_whichever_way_some_triangles_turn(device, make):
    triangles = make().triangles.copy()
    assert found(device, triangles) == []
    triangles[::3] = triangles[::3, ::-1]
    assert found(device, triangles) == []
    assert found(device, triangles[1:]) == counted(triangles[1:])


def test_seam_where_vertices_are_parted_is_no_border(device):
    whole = plane(12)
    parted = whole.triangles.copy()
    right = whole.positions[whole.triangles].mean(axis=1)[:, 0] > whole.positions[:, 0].mean()
    parted[right] += whole.vertex_count
    mesh = TriangleMesh(np.concatenate([whole.positions, whole.positions]), parted)
    edges = Upload(device, mesh).border_edges
    assert len(edges) == 48
    assert np.array_equal(edges % whole.vertex_count, Upload(device, whole).border_edges)


def test_many_chunks_find_the_same(device):
    triangles = plane(120, 90).triangles
    assert found(device, triangles) == counted(triangles)


def clustered(device, mesh, **params):
    prepared = prepare(device, mesh, Params(**params))
    run(device, prepared)
    assert prepared.check().passed
    return prepared.result()[0]


@pytest.mark.parametrize("way", WAYS)
def test_border_of_a_slanted_sheet_stays_on_its_lines(device, way):
    sheet = plane(40)
    turn = np.array([[0.8, 0.36, 0.48], [-0.6, 0.48, 0.64], [0, -0.8, 0.6]])
    mesh = TriangleMesh(sheet.positions @ turn.T, sheet.triangles)
    low, high = sheet.box

    def shrunk(border):
        points = clustered(device, mesh, cells=9, border=border, **WAYS[way]).positions @ turn
        return max((high - points.max(axis=0))[:2].max(), (points.min(axis=0) - low)[:2].max())

    assert shrunk("quadrics") < 0.1 * shrunk("none")


def test_border_quadrics_come_nearer_to_an_open_surface(device):
    mesh = terrain(60)

    def error(border):
        made = clustered(device, mesh, cells=16, border=border)
        return quality.measure(mesh, made, samples=20_000)["rms_error"]

    assert error("quadrics") < 0.8 * error("none")


def test_closed_meshes_are_the_same_to_the_bit(device):
    held, plain = (
        clustered(device, torus(40, 30), cells=12, border=b) for b in ("quadrics", "none")
    )
    assert held.positions.tobytes() == plain.positions.tobytes()
    assert np.array_equal(held.triangles, plain.triangles)


@pytest.mark.parametrize("target", [{"cells": 9}, {"target_count": 700}])
@pytest.mark.parametrize("way", WAYS)
def test_kept_border_vertices_are_where_they_were_and_come_last(device, way, target):
    mesh = terrain(40)
    mesh = TriangleMesh(mesh.positions + np.array([100, 0, 0]), mesh.triangles)
    prepared = prepare(device, mesh, Params(border="keep", **target, **WAYS[way]))
    run(device, prepared)
    (result,) = prepared.result()
    assert prepared.counters()["triangles"] == result.triangle_count
    kept = border_vertices(Upload(device, mesh).border_edges)
    rows = prepared.vertex_map()[kept]
    own = rows[rows != 0xFFFFFFFF]
    assert len(np.unique(own)) == len(own) > 0.9 * len(kept)
    assert np.array_equal(
        np.sort(own), np.arange(result.vertex_count - len(own), result.vertex_count)
    )
    assert np.array_equal(result.positions[own], mesh.positions[kept[rows != 0xFFFFFFFF]])
    if "target_count" in target:
        assert 0.95 * 700 <= result.triangle_count <= 700


def test_paper_and_average_are_as_published(device):
    for placement in ("paper", "average"):
        made = [
            clustered(device, terrain(30), cells=8, placement=placement, border=border)
            for border in ("quadrics", "none")
        ]
        assert made[0].positions.tobytes() == made[1].positions.tobytes()


def test_reference_of_kept_border_has_the_positions_given():
    mesh = terrain(20)
    found = simplify(mesh, Params(6, border="keep"))
    given_points = {tuple(p) for p in mesh.positions.tolist()}
    assert sum(tuple(p) in given_points for p in found.mesh.positions.tolist()) >= 70
