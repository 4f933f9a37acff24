import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import (
    BezierPatches,
    GeometryImage,
    TriangleMesh,
)

POINTS = np.eye(3)
FACE = np.array([(0, 1, 2)])


def test_triangle_mesh_takes_any_number_and_keeps_float32():
    mesh = TriangleMesh(POINTS.astype(np.float64), FACE.astype(np.int16))
    assert mesh.positions.dtype == np.float32 and mesh.triangles.dtype == np.uint32
    with pytest.raises(ValueError, match="read-only"):
        mesh.positions[0] = 1


def test_triangle_mesh_leaves_the_given_array_writeable():
    given = np.zeros((3, 3), np.float32)
    mesh = TriangleMesh(given, FACE)
    assert np.shares_memory(mesh.positions, given)
    given[0] = 1


@pytest.mark.parametrize(
    "arguments, error, message",
    [
        ((POINTS[:, :2], FACE), ValueError, r"points: expected \(n, 3\) float32, got shape"),
        ((POINTS, FACE.astype(float)), TypeError, "faces: expected .* uint32, got dtype float64"),
        ((POINTS, [(0, 1, 3)]), ValueError, "faces: expected indices from 0 to 2, got 3"),
        ((POINTS, [(0, -1, 2)]), ValueError, "faces: expected indices from 0 to 2, got -1"),
        ((POINTS[:0], FACE), ValueError, "faces: expected no triangles with no points"),
        ((POINTS * np.nan, FACE), ValueError, "points: expected finite"),
        ((POINTS * 1e39, FACE), ValueError, "points: expected finite"),
        ((POINTS, FACE, POINTS[:2]), ValueError, r"normals: expected \(3, 3\)"),
        ((POINTS, FACE, None, POINTS), ValueError, r"uvs: expected \(3, 2\)"),
        ((POINTS > 0, FACE), TypeError, "points: expected .* got dtype bool"),
    ],
)
def test_triangle_mesh_names_what_is_wrong(arguments, error, message):
    with pytest.raises(error, match=message):
        TriangleMesh(*arguments)


def test_triangle_mesh_of_empty_lists_is_empty():
    mesh = TriangleMesh([], [])
    assert (mesh.vertex_count, mesh.triangle_count, mesh.diagonal) == (0, 0, 0.0)
    assert mesh.with_normals().normals.shape == (0, 3)


@pytest.mark.parametrize("scale", [1e-30, 1.0, 1e30])
def test_with_normals_is_unit_at_every_scale(scale):
    mesh = TriangleMesh(POINTS * scale, FACE).with_normals()
    assert np.allclose(mesh.normals, 3**-0.5, atol=1e-6)
    assert mesh.with_normals() is mesh


def test_with_normals_of_a_vertex_without_area_points_up():
    mesh = TriangleMesh(POINTS, [(0, 0, 1)]).with_normals()
    assert mesh.normals.tolist() == [[0, 0, 1]] * 3


def test_other_surfaces_name_what_is_wrong():
    with pytest.raises(ValueError, match=r"points: expected \(n, 4, 4, 3\)"):
        BezierPatches(np.zeros((2, 3, 3, 3)))
    with pytest.raises(ValueError, match=r"positions: expected \(2\^n \+ 1"):
        GeometryImage(np.zeros((4, 4, 3)), np.zeros((4, 4, 3)))
    with pytest.raises(ValueError, match="normals: expected shape"):
        GeometryImage(np.zeros((5, 5, 3)), np.zeros((3, 3, 3)))


def test_tags_of_edges_belong_to_triangles():
    tags = np.arange(6).reshape(1, 3, 2)
    mesh = TriangleMesh(np.eye(3), [[0, 1, 2]], edge_tags=tags)
    assert mesh.edge_tags.dtype == np.float32 and np.array_equal(mesh.edge_tags, tags)
    for wrong in (tags[0], np.zeros((2, 3, 2)), np.zeros((1, 3, 3))):
        with pytest.raises(ValueError, match="edge_tags: expected"):
            TriangleMesh(np.eye(3), [[0, 1, 2]], edge_tags=wrong)
    with pytest.raises(ValueError, match="edge_tags"):
        TriangleMesh(np.eye(3), [[0, 1, 2]], edge_tags=np.full((1, 3, 2), np.nan))


def test_normals_are_shared_at_a_place_where_uvs_part_vertices():
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 1], [0, 1, 0]]
    hinge, uvs = [[0, 1, 2], [3, 4, 5]], np.arange(12).reshape(6, 2)
    parted = TriangleMesh(points, hinge, uvs=uvs).with_normals().normals
    whole = TriangleMesh(points, [[0, 1, 2], [1, 4, 2]]).with_normals().normals
    assert np.array_equal(parted, whole[[0, 1, 2, 1, 4, 2]])
    hard = TriangleMesh(points, hinge).with_normals().normals
    assert not np.array_equal(hard[1], hard[3]), "without uvs they are parted for the edge's sake"


def test_bare_has_points_and_triangles_alone():
    mesh = TriangleMesh(
        POINTS, FACE, normals=POINTS, edge_tags=np.zeros((1, 3, 2)), origin=(1, 2, 3)
    )
    bare = mesh.bare()
    assert bare.normals is None and bare.edge_tags is None
    assert np.array_equal(bare.origin, mesh.origin) and bare.bare() is bare
