import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen import patches
from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels.bezier.borders import borders_of, seams, sharing
from lodbench.kernels.bezier.lattice import lattice_parameters, stored_map
from lodbench.kernels.bezier.reference import (
    bernstein,
    bernstein_slopes,
    normals_at,
    patch_scales,
    points_at,
)
from tests.kernels.bezier.patches import NASTY, sheet, sheets


@pytest.mark.parametrize("level", range(11))
def test_map_is_the_same_to_the_bit_from_either_end(level):
    side = (1 << level) + 1
    planes = stored_map(level)[:, :side]
    assert np.array_equal(planes[:4, ::-1], planes[3::-1])
    assert np.array_equal(planes[4:7, ::-1], planes[6:3:-1])
    assert np.array_equal(planes[:4, [0, -1]].T, [(1, 0, 0, 0), (0, 0, 0, 1)])
    assert np.allclose(planes[:4].sum(0), 1) and (planes[:7] >= 0).all()


def test_basis_has_the_properties_that_the_thesis_lists():
    t = np.linspace(0, 1, 101)
    J = bernstein(t)
    assert (J >= 0).all() and np.allclose(J.sum(1), 1)
    assert np.allclose(J, bernstein(1 - t)[:, ::-1])
    J2 = bernstein_slopes(t)
    zero = np.zeros((101, 1))
    raised = np.hstack([J2, zero]) * (1 - t)[:, None] + np.hstack([zero, J2]) * t[:, None]
    assert np.allclose(J, raised)  # the recursion


def test_points_lie_in_the_hull_and_begin_at_the_corners():
    P = sheet(1).points.astype(np.float64)
    points = points_at(P, *lattice_parameters(3))
    assert (points.max(1) <= P.max((1, 2)) + 1e-12).all()
    assert np.allclose(points[:, [0, 8, 72, 80]].reshape(-1, 2, 2, 3), P[:, ::3, ::3])


def test_normals_are_across_both_derivatives():
    P, step = sheet(2).points.astype(np.float64), 1e-6
    u, v = np.array([0.3, 0.7]), np.array([0.6, 0.2])
    normals, certain = normals_at(P, u, v)
    assert certain.all()
    along_u = points_at(P, u + step, v) - points_at(P, u - step, v)
    along_v = points_at(P, u, v + step) - points_at(P, u, v - step)
    across = np.cross(along_u, along_v)
    assert np.allclose(normals, across / np.linalg.norm(across, axis=-1, keepdims=True), atol=1e-6)


@given(st.floats(1e-30, 1e30))
def test_scale_brings_a_patch_near_one(size):
    (scale,) = patch_scales(sheet(4).points[:1] * np.float32(size))
    assert np.log2(scale) == int(np.log2(scale))
    assert 0.2 < np.ptp(sheet(4).points[0].reshape(-1, 3), axis=0).max() * size * scale < 4


def brute_force(surface, level):
    """Classes of vertices that are one by place alone, of patches that coincide only along their borders."""
    points = points_at(surface.points.astype(np.float64), *lattice_parameters(level))
    keys = np.round(points.reshape(-1, 3) / np.abs(points).max() * 1e7).astype(np.int64)
    return np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1)


@settings(max_examples=15, deadline=None)
@given(sheets, st.integers(0, 4))
def test_sharing_is_that_of_places(surface, level):
    welded, count = sharing(borders_of(surface.points), level)
    assert set(np.unique(welded)) == set(range(count))
    place = brute_force(surface, level)
    pairs = np.unique(np.stack([welded.ravel(), place], axis=1), axis=0)
    assert len(pairs) == count == place.max() + 1


@pytest.mark.parametrize("surface", [patches.pot(8), patches.cup()], ids=["pot", "cup"])
def test_sharing_of_generated_patches_is_that_of_places(surface):
    welded, count = sharing(borders_of(surface.points), 3)
    place = brute_force(surface, 3)
    pairs = np.unique(np.stack([welded.ravel(), place], axis=1), axis=0)
    assert len(pairs) == count  # no two places are one vertex
    assert count >= place.max() + 1  # a handle may touch the bowl


@settings(max_examples=10, deadline=None)
@given(st.lists(st.integers(0, 7), min_size=9, max_size=9), st.integers(1, 4))
def test_seams_lead_to_the_same_place(turns, level):
    # a sheet without waves is smooth throughout, whichever way its patches are named; those turned over are not
    flat = np.stack(
        [*np.meshgrid(np.arange(10.0), np.arange(10.0), indexing="ij"), np.zeros((10, 10))], -1
    )
    surface = BezierPatches(np.array([
        flat[3 * i : 3 * i + 4, 3 * j : 3 * j + 4] for i in range(3) for j in range(3)
    ]))  # fmt: skip
    found = borders_of(surface.points)
    assert found.counts() == {
        "shared_edges": 12, "open_edges": 12, "collapsed_edges": 0, "smooth_edges": 12,
    }  # fmt: skip
    points = points_at(surface.points.astype(np.float64), *lattice_parameters(level))
    patch, vertex, other, other_vertex = seams(found, level).T
    assert np.allclose(points[patch, vertex], points[other, other_vertex])
    pairs = set(zip(other.tolist(), other_vertex.tolist(), strict=True))
    assert not pairs & set(zip(patch.tolist(), vertex.tolist(), strict=True))  # no chain of copies
    n = 1 << level
    assert len(patch) == 12 * (n - 1) + 36 - 16  # on borders, and all but one at each of 16 corners


@pytest.mark.parametrize("name", NASTY)
def test_borders_bear_nasty_patches(name):
    surface = BezierPatches(NASTY[name])
    found = borders_of(surface.points)
    assert sum(found.counts().values()) > 0
    welded, count = sharing(found, 2)
    assert welded.max() < count
    seams(found, 2)


def test_no_patches_have_no_borders():
    found = borders_of(np.zeros((0, 4, 4, 3), np.float32))
    assert set(found.counts().values()) == {0}
    assert sharing(found, 3)[1] == 0 and len(seams(found, 3)) == 0
