"""Which vertices are not one fan: the device says what a walk around each says."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen.triangles import displaced_icosphere, icosphere, terrain, torus
from lodbench.kernels import simplify_mesh
from lodbench.kernels.cluster import links
from lodbench.kernels.cluster.manifold import part

SURFACES = (torus(9, 6), icosphere(1), displaced_icosphere(4), terrain(6))


def glued(seed, places, surface):
    """A surface's vertices thrown together at random, and places for them."""
    random = np.random.default_rng(seed)
    mesh = SURFACES[surface]
    triangles = random.integers(0, places, mesh.vertex_count)[mesh.triangles]
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)].astype(np.uint32)
    return random.standard_normal((places, 3)), triangles


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([4, 9, 40, 200]), st.integers(0, 3))
def test_device_and_reference_agree_on_any_gluing(device, seed, places, surface):
    _, triangles = glued(seed, places, surface)
    assert np.array_equal(
        links.troubled(device, triangles, places), links.reference(triangles, places)
    )


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([6, 20, 60]), st.integers(0, 3))
def test_parting_what_is_troubled_is_parting_all(device, seed, places, surface):
    points, triangles = glued(seed, places, surface)
    whole = part(points, triangles)
    some = part(points, triangles, links.troubled(device, triangles, places))
    assert np.array_equal(whole.rows, some.rows)
    # fans of a vertex are in the same order, so that output vertices are
    for one, other in zip(whole.fans.ravel(), some.fans.ravel(), strict=True):
        assert (whole.fans == one).tolist() == (some.fans == other).tolist()
    corners = triangles[whole.rows].ravel().astype(np.int64)
    ours, theirs = (
        np.lexsort((some.fans.ravel(), corners)),
        np.lexsort((whole.fans.ravel(), corners)),
    )
    assert np.array_equal(some.fans.ravel()[ours] < places, some.fans.ravel()[theirs] < places)


@pytest.mark.parametrize("mesh", SURFACES)
def test_surfaces_have_no_trouble(device, mesh):
    assert not links.troubled(device, mesh.triangles, mesh.vertex_count).any()


def test_two_triangles_back_to_back_and_crowded_vertices_are_troubled(device):
    back = np.array([(0, 1, 2), (0, 2, 1)], np.uint32)
    assert links.troubled(device, back, 4).tolist() == [True, True, True, False]
    count = links.MOST + 1
    around = np.arange(1, count + 1)
    fan = np.stack([np.zeros(count, int), around, np.roll(around, -1)], 1).astype(np.uint32)
    assert np.flatnonzero(links.troubled(device, fan, count + 1)).tolist() == [0]
    assert not links.troubled(device, np.zeros((0, 3), np.uint32), 3).any()


@pytest.mark.parametrize("reduction", [0.9, 0.97])
def test_a_parted_mesh_has_the_target_to_a_hundredth(device, reduction):
    mesh = displaced_icosphere(40).bare()
    result = simplify_mesh(
        device, mesh, target_reduction=reduction, manifold=True, method="quadric_clustering"
    )
    assert 0 <= result.counters["target_gap"] <= 0.01 * result.counters["target"] + 2
    assert result.mesh.triangle_count == result.counters["triangles"]
