import numpy as np
import pytest
from scipy.optimize import linprog

from lodbench.datasets_gen import shapes, triangles
from lodbench.datasets_gen.surfaces import TriangleMesh
from tests.datasets_gen.topology import soup, topology


def sees_its_whole_inside(mesh):
    """Whether one point lies behind every triangle: then the solid is star-shaped."""
    corners = mesh.positions.astype(np.float64)[mesh.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    limits = np.einsum("ij,ij->i", normals, corners[:, 0])
    return linprog(np.zeros(3), normals, limits, bounds=(None, None)).status == 0


def test_blob_with_ears_is_closed_and_not_star_shaped():
    mesh = shapes.blob_with_ears(20)
    found = topology(mesh)
    assert mesh.triangle_count == 8000
    assert (found.euler, found.border, found.repeated, found.unused) == (2, 0, 0, 0)
    assert found.volume > 0
    assert not sees_its_whole_inside(mesh)


def test_star_shape_check_accepts_a_sphere():
    assert sees_its_whole_inside(triangles.icosphere(2))


@pytest.mark.parametrize("sharp", [False, True])
@pytest.mark.parametrize("block, genus", [(1, 0), (1, 1), (3, 1), (2, 3), (4, 6), (1, 7)])
def test_plate_has_the_genus_asked_for(block, genus, sharp):
    found = topology(shapes.plate(block, genus, sharp))
    assert found.euler == 2 - 2 * genus
    assert (found.border, found.repeated, found.unused) == (0, 0, 0)
    assert found.volume > 0


def test_sharp_plate_is_flat_on_top():
    mesh = shapes.plate(3, 2, sharp=True)
    assert len(np.unique(mesh.positions[:, 2])) == 2


@pytest.mark.parametrize("block, genus", [(0, 1), (1, -1)])
def test_plate_refuses_sizes_that_make_no_plate(block, genus):
    with pytest.raises(ValueError, match="expected at least"):
        shapes.plate(block, genus)


def test_spool_is_closed_and_its_two_rims_are_creases():
    mesh = shapes.spool(9)
    found = topology(mesh)
    assert (mesh.triangle_count, mesh.vertex_count) == (162, 83)
    assert (found.euler, found.border, found.repeated, found.unused) == (2, 0, 0, 0)
    assert found.volume > 0
    sharp = mesh.tags[:, 1] == 1
    assert not mesh.tags[:, [0, 2]].any() and sharp.sum() == 18
    edges = np.concatenate([mesh.triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    creased = edges[sharp[edges].all(1)]
    assert len(creased) == 2 * 18, "edges along the rims, each from both sides, and no others"
    radius = np.hypot(mesh.positions[:, 0], mesh.positions[:, 2])
    assert np.allclose(radius[creased], 1)


def test_spool_refuses_sizes_whose_rims_touch():
    with pytest.raises(ValueError, match="slices: expected at least 6, got 5"):
        shapes.spool(5)


def test_bumpy_keeps_the_triangles_and_moves_as_far_as_asked():
    smooth = shapes.blob_with_ears(30)
    rough = shapes.bumpy(smooth, height=0.01, seed=3)
    assert np.array_equal(rough.triangles, smooth.triangles)
    moved = np.linalg.norm(rough.positions - smooth.positions, axis=1) / smooth.diagonal
    assert np.sqrt((moved**2).mean()) == pytest.approx(0.01, rel=0.3)
    assert np.array_equal(rough.positions, shapes.bumpy(smooth, 0.01, seed=3).positions)
    assert not np.array_equal(rough.positions, shapes.bumpy(smooth, 0.01, seed=4).positions)


@pytest.mark.parametrize("holes", [0, 1, 5])
def test_pierced_has_one_border_per_hole(holes):
    whole = shapes.blob_with_ears(40)
    mesh = shapes.pierced(whole, holes)
    found = topology(mesh)
    assert found.euler == 2 - holes
    assert (found.border > 0) == (holes > 0)
    assert (found.repeated, found.unused) == (0, 0)
    assert set(map(tuple, soup(mesh))) <= set(map(tuple, soup(whole)))


def test_opened_is_a_disc_and_keeps_the_attributes():
    whole = triangles.icosphere(3)
    mesh = shapes.opened(whole)
    found = topology(mesh)
    assert (found.euler, found.repeated, found.unused) == (1, 0, 0)
    assert found.border > 0
    assert np.array_equal(mesh.normals, mesh.positions)
    # a triangle goes where all of it is in the top fifth: the border stays, and reaches over it
    high = whole.positions[whole.triangles][..., 2] > 0.6
    assert mesh.triangle_count == whole.triangle_count - high.all(1).sum()
    assert mesh.positions[:, 2].max() > 0.6


def test_pierced_of_nothing_is_nothing():
    empty = TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), np.uint32))
    assert shapes.opened(empty).triangle_count == 0
