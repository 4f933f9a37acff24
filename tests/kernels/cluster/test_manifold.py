"""Parted sheets: every edge has two triangles at most, every vertex one fan, and nothing moves."""

import dataclasses
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import displaced_icosphere, icosphere, terrain, torus
from lodbench.harness.measure.quality import topology
from lodbench.kernels import simplify_mesh
from lodbench.kernels.cluster.manifold import part
from lodbench.kernels.cluster.turned import NO_VERTEX
from tests.kernels.cluster.meshes import wavy_sheet

METHODS = ("quadric_clustering", "vertex_average", "octree")


def shell():
    """A hollow ball whose two sides meet in the cells of coarse grids."""
    outer = icosphere(4).bare()
    sides = outer.positions, 0.93 * outer.positions
    inside = outer.triangles[:, ::-1] + outer.vertex_count
    return TriangleMesh(np.concatenate(sides), np.concatenate([outer.triangles, inside]))


def fans_of(triangles):
    """Vertex -> how many fans of triangles it has, by walking across edges with two triangles."""
    at = {}
    for row, triangle in enumerate(triangles.tolist()):
        for vertex in triangle:
            at.setdefault(vertex, []).append((row, {*triangle} - {vertex}))
    counts = {}
    for vertex, around in at.items():
        left, fans = list(around), 0
        while left:
            fans += 1
            reach = set(left.pop()[1])
            while grown := [entry for entry in left if entry[1] & reach]:
                for entry in grown:
                    reach |= entry[1]
                left = [entry for entry in left if entry not in grown]
        counts[vertex] = fans
    return counts


def assert_manifold(mesh, closed):
    found = topology(mesh)
    assert found["nonmanifold_edges"] == found["flipped_edges"] == 0
    assert found["duplicate_triangles"] == 0
    assert not closed or found["open_edges"] == 0
    assert set(fans_of(mesh.triangles).values()) <= {1}


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 9), st.sampled_from(["torus", "sphere", "shell"]))
def test_any_gluing_of_a_closed_surface_parts_into_manifolds(seed, places, kind):
    """Vertices thrown together at random: far worse than any grid makes."""
    random = np.random.default_rng(seed)
    mesh = {"torus": torus(9, 6), "sphere": icosphere(1), "shell": displaced_icosphere(4)}[kind]
    glued = random.integers(0, places, mesh.vertex_count)
    triangles = glued[mesh.triangles]
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    positions = random.standard_normal((places, 3)).astype(np.float32)
    found = part(positions, triangles)
    corners = triangles[found.rows]
    # a fan is at one place, and what is taken away bounds nothing
    assert all(len(set(corners[found.fans == fan])) == 1 for fan in np.unique(found.fans))
    gone = np.delete(triangles, found.rows, axis=0)
    assert_cancels(gone)
    _, at = np.unique(found.fans, return_inverse=True)
    place = np.zeros((at.max(initial=-1) + 1, 3))
    place[at.ravel()] = positions[corners.ravel()]
    assert_manifold(TriangleMesh(place, at.reshape(-1, 3)), closed=True)


def assert_cancels(triangles):
    """Each set of three vertices is there as often one way as the other."""
    ways = Counter()
    for a, b, c in triangles.tolist():
        low = min(a, b, c)
        turn = {a: (a, b, c), b: (b, c, a), c: (c, a, b)}[low]
        ways[tuple(sorted(turn))] += 1 if turn[1] < turn[2] else -1
    assert not any(ways.values())


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("cells", [3, 7, 20])
def test_closed_meshes_stay_closed_and_become_manifold(device, method, cells):
    for mesh in (torus(60, 30).bare(), displaced_icosphere(24).bare(), shell()):
        before = (
            simplify_mesh(device, mesh, cells=cells, method=method) if method != "octree" else None
        )
        asked = {"target_count": 30 * cells} if method == "octree" else {"cells": cells}
        result = simplify_mesh(device, mesh, **asked, method=method, manifold=True)
        assert_manifold(result.mesh, closed=True)
        counters = result.counters
        assert counters["duplicate_triangles"] == 0
        assert counters["vertices"] == result.mesh.vertex_count
        assert counters["triangles"] == result.mesh.triangle_count
        assert set(np.unique(result.mesh.triangles)) == set(range(result.mesh.vertex_count))
        if before is not None:
            gone = before.mesh.triangle_count - result.mesh.triangle_count
            assert counters["back_to_back_removed"] == gone
            ours, theirs = (set(map(bytes, one.mesh.positions)) for one in (result, before))
            assert ours <= theirs, "vertices stay where they were"


def test_attributes_come_along_and_the_map_leads_to_corners(device):
    mesh = shell()
    mesh = dataclasses.replace(mesh, colours=np.abs(mesh.positions) / 8)
    plain = simplify_mesh(device, mesh, cells=8)
    result = simplify_mesh(device, mesh, cells=8, manifold=True)
    assert result.counters["parted_vertices"] > 0, "else nothing is asked"
    assert_manifold(result.mesh.bare(), closed=True)
    there = result.vertex_map != NO_VERTEX
    assert np.array_equal(
        result.mesh.positions[result.vertex_map[there]],
        plain.mesh.positions[plain.vertex_map[there]],
    )
    assert result.mesh.colours is not None and plain.mesh.colours is not None
    ours, theirs = result.mesh.colours, plain.mesh.colours
    assert np.array_equal(ours[result.vertex_map[there]], theirs[plain.vertex_map[there]])


def test_borders_stay_open_and_flipped_triangles_may_go_too(device):
    for mesh in (terrain(40), wavy_sheet()):
        result = simplify_mesh(device, mesh, cells=7, manifold=True, remove_flipped=True)
        found = topology(result.mesh)
        assert found["nonmanifold_edges"] == 0
        assert found["open_edges"] > 0
        assert set(fans_of(result.mesh.triangles).values()) <= {1}


def test_what_has_no_partner_stays_open():
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]], float)
    three = np.array([(0, 1, 2), (1, 0, 3), (0, 1, 4)])  # two that run the same way along an edge
    found = part(positions, three)
    assert len(found.rows) == 3
    joined = [
        len(set(found.fans[found.rows == row].ravel()) & set(found.fans[1])) for row in (0, 2)
    ]
    assert sorted(joined) == [0, 2], (
        "one of them is its neighbour's partner, the other stands alone"
    )
    nothing = part(np.zeros((0, 3)), np.zeros((0, 3), np.uint32))
    assert nothing.fans.shape == (0, 3) and not len(nothing.rows)


def test_two_boxes_that_share_an_edge_part_solid_by_solid(device):
    """Each keeps its own triangles around the edge that both have."""
    low = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    points = np.concatenate([low, low + np.array((1, 1, 0))])
    both = np.concatenate([faces, faces + 8])
    _, place = np.unique(points, axis=0, return_inverse=True)
    welded = place.reshape(-1)[both]
    where = np.unique(points, axis=0)
    found = part(where, welded)
    assert len(found.rows) == 24
    assert not set(found.fans[:12].ravel()) & set(found.fans[12:].ravel())
