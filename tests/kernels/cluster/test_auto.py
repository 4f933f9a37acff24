"""What is taken for which mesh, and that the outcome keeps the surface and meets the target."""

import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import displaced_icosphere, icosphere, terrain, torus
from lodbench.harness.measure.quality import topology
from lodbench.kernels import simplify, simplify_mesh
from lodbench.kernels.cluster.auto import choice, reference
from lodbench.kernels.cluster.auto.choice import choose, flat_share
from lodbench.kernels.cluster.auto.simplify import joined_places
from tests.kernels.cluster.meshes import cube, flat_lattice

BALL = displaced_icosphere(24).bare()


def reasons(result):
    return {name for name in result.counters if name.startswith(("took_", "because_"))}


@pytest.mark.parametrize(
    ("options", "method", "why"),
    [
        ({"cells": 9}, "quadric_clustering", "cells"),
        ({"target_count": 300}, "edge_collapse", "small"),
        ({"target_count": 300, "manifold": True}, "quadric_clustering", "options"),
        ({"target_count": 300, "shape": "cubes"}, "octree", "options"),
        ({"target_count": 300, "factor": 2.0}, "hybrid", "options"),
    ],
)
def test_counters_say_what_was_taken_and_why(device, options, method, why):
    result = simplify_mesh(device, BALL, **options)
    assert reasons(result) == {f"took_{method}", f"because_{why}"}
    own = simplify_mesh(device, BALL, method=method, **options)
    assert np.array_equal(result.mesh.positions, own.mesh.positions)
    assert np.array_equal(result.mesh.triangles, own.mesh.triangles)
    assert set(own.counters) <= set(result.counters)


def test_large_meshes_go_by_target_and_flatness(monkeypatch):
    monkeypatch.setattr(choice, "LARGE", 500)
    count = BALL.triangle_count
    assert choose(BALL, count // 20).why == "large"
    assert choose(BALL, count // 2).why == "near"
    assert choose(flat_lattice(40), 80).why == "flat"


def test_flatness_is_what_the_reference_says():
    for mesh in (BALL, terrain(12).bare(), flat_lattice(9), cube(3), icosphere(2).bare()):
        assert flat_share(mesh) == reference.flat_share(mesh, choice.EVEN)
    assert flat_share(TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int))) == 0


@pytest.mark.parametrize("large", [False, True])
def test_closed_surfaces_keep_their_genus_and_meet_the_target(device, monkeypatch, large):
    if large:
        monkeypatch.setattr(choice, "LARGE", 0)
    for mesh in (BALL, torus(60, 30).bare()):
        result = simplify_mesh(device, mesh, target_reduction=0.93)
        assert ("took_hybrid" in result.counters) == large
        before, after = topology(mesh), topology(result.mesh)
        for key in ("components", "euler", "open_edges", "nonmanifold_edges"):
            assert after[key] == before[key]
        assert 0 <= result.counters["target_gap"] <= 1


def test_points_at_one_place_are_one_where_the_mesh_is_in_pieces(device):
    """An STL file has three points for each triangle."""
    soup = BALL.positions[BALL.triangles].reshape(-1, 3)
    faces = np.arange(len(soup)).reshape(-1, 3)
    points, left = simplify(soup, faces, 0.9, device=device)
    whole, _ = simplify(BALL.positions, BALL.triangles, 0.9, device=device)
    assert len(left) == BALL.triangle_count // 10
    assert topology(TriangleMesh(points, left))["open_edges"] == 0
    assert len(points) == len(whole)
    result = simplify_mesh(device, (soup, faces), target_reduction=0.9)
    assert result.vertex_map is not None and len(result.vertex_map) == len(soup)
    by_place = result.vertex_map[np.lexsort(soup.T)]
    same = (np.diff(soup[np.lexsort(soup.T)], axis=0) == 0).all(axis=1)
    assert (by_place[1:][same] == by_place[:-1][same]).all()


def test_sheets_of_a_closed_mesh_that_touch_stay_apart(device):
    one = icosphere(3).bare()
    other = one.positions + 2 * one.positions[0]  # they share one place
    mesh = TriangleMesh(
        np.concatenate([one.positions, other]),
        np.concatenate([one.triangles, one.triangles + one.vertex_count]),
    )
    result = simplify_mesh(device, mesh, target_reduction=0.8)
    assert topology(result.mesh)["components"] == 2


def test_open_sheets_that_touch_inside_stay_apart(device):
    one = terrain(8).bare()
    middle = one.vertex_count // 2  # on no border; the other sheet has the same place there
    other = one.positions.copy()
    other[:, 2] = 2 * one.positions[middle, 2] - one.positions[:, 2]
    both = TriangleMesh(
        np.concatenate([one.positions, other]),
        np.concatenate([one.triangles, one.triangles + one.vertex_count]),
    )
    assert joined_places(device, both) == (both, None)


def test_unknown_options_and_pairs_that_no_method_takes_are_one_line(device):
    with pytest.raises(TypeError, match="option: expected one like placement, got 'placment'"):
        simplify_mesh(device, BALL, target_count=9, placment="robust")
    with pytest.raises(TypeError, match="method: expected one to be named that takes"):
        simplify_mesh(device, BALL, target_count=9, sweeps=3, placement="robust")
