import numpy as np
import pytest
import trimesh

from lodbench.datasets_gen.read import FileError, read_mesh

SQUARE = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
UVS = b"vt 0 0\nvt 1 0\nvt 1 1\nvt 0.5 0.5\n"
NORMALS = b"vn 0 0 1\nvn 0 0 2\nvn 0 1 0\n"


@pytest.fixture
def parsed(tmp_path):
    """Reads a file of these bytes."""

    def call(data):
        (tmp_path / "mesh.obj").write_bytes(data)
        return read_mesh(tmp_path / "mesh.obj")

    return call


def from_lowest(triangles):
    """Each triangle turned so that its lowest corner is first: the same triangle."""
    return [np.roll(t, -int(np.argmin(t))).tolist() for t in triangles]


@pytest.mark.parametrize(
    "faces",
    [
        b"f 1 2 3\nf 1 3 4\n",
        b"f 1 2 3 4\n",
        b"f\t1  2 3 \r\nf 1 3 4",
        b"f 1// 2// 3// 4//\n",
        b"f 1/ 2/ 3/ 4/\n",
        b"f -4 -3 -2 -1\n",
        b"f 1 2 \\\n3 4\n",
        b"f 1 2\\\r\n3 4\n",
        b"  f 1 2 3\nf 1 3 4\nl 1 2\nf 1 2\n",
        b"o a\ng b c\ns off\nusemtl d\nf 1 2 3 # a comment\nmtllib e.mtl\nusemtl e\nf 1 3 4\nl 1 2\n",
        UVS + NORMALS + b"f 1/1/1 2/2/1 3/3/1 4\n",
        UVS + NORMALS + b"f 1/1/1 2/2/2 3/3/3\nf 1/4/2 3//2 4\n",
    ],
)
def test_obj_square_in_many_spellings(parsed, faces):
    mesh = parsed(b"# comment\n" + SQUARE + faces)
    assert from_lowest(mesh.triangles) == [[0, 1, 2], [0, 2, 3]]
    assert mesh.positions.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    assert mesh.uvs is None and mesh.normals is None


def test_obj_relative_numbers_before_the_last_point_are_refused(parsed):
    text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf -3 -2 -1\n"
    with pytest.raises(FileError, match="expected relative numbers after the last point"):
        parsed(text)


def test_obj_point_with_several_uvs_and_normals_is_as_many_vertices(parsed):
    mesh = parsed(SQUARE + UVS + NORMALS + b"f 1/1/1 2/2/1 3/3/2\nf 1/4/3 3/3/2 4/1/3\n")
    assert mesh.triangles.tolist() == [[0, 1, 2], [4, 2, 3]]
    assert mesh.positions.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 0]]
    assert mesh.uvs.tolist() == [[0, 0], [1, 0], [1, 1], [0, 0], [0.5, 0.5]]
    assert mesh.normals.tolist() == [[0, 0, 1], [0, 0, 1], [0, 0, 2], [0, 1, 0], [0, 1, 0]]


@pytest.mark.parametrize(
    "faces",
    [
        b"f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n",
        b"f 1/1 2/2 3/3 4/4\n",
        b"f -4/-4 -3/-3 -2/-2 -1/-1\n",
        b"f\t1/1/  2/2  3/3/\r\nf 1/1 3/3 \\\n4/4 # a comment 1/1\n",
        b"o a\nusemtl b\ns 1\n f 1/1 2/2 3/3\nusemtl c\n f 1/1/1 3/3/2 4/4/3\nl 1/1 2/2\n",
    ],
)
def test_obj_uvs_come_in_many_spellings(parsed, faces):
    mesh = parsed(SQUARE + UVS + NORMALS + faces)
    assert mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert mesh.positions.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    assert mesh.uvs.tolist() == [[0, 0], [1, 0], [1, 1], [0.5, 0.5]]
    assert mesh.normals is None, "not every corner has one"


def test_obj_equal_uvs_under_several_numbers_part_nothing(parsed):
    again = b"vt 0 0\nvt 1.0 -0 0\nvt 1 1\n" + UVS + b"f 1/1 2/2 3/3\nf 1/4 3/6 4/7\n"
    mesh = parsed(SQUARE + again)
    assert mesh.vertex_count == 4 and mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]


def test_obj_polygons_with_normals_are_fans_and_points_without_corners_stay(parsed):
    points = b"v 9 9 9 1 0 0\nv 0 0 0 1 1 0\nv 1 0 0 1 1 1\nv 1 1 0 0 0 0\nv 0 1 0 0 1 0\nv -1 0 0 0 0 1\n"
    mesh = parsed(points + b"vn 0 0 1\nf 2//1 3//1 4//1 5//1 6//1\n")
    assert mesh.triangles.tolist() == [[1, 2, 3], [1, 3, 4], [1, 4, 5]]
    assert mesh.colours[0].tolist() == [1, 0, 0] and mesh.uvs is None
    assert mesh.normals.tolist() == [[0, 0, 1]] * 6


@pytest.mark.parametrize(
    "text",
    [
        SQUARE + UVS + b"f 1/1 2/2 3/9\n",
        SQUARE + UVS + b"f 1/1 2/2 3/0\n",
        SQUARE + UVS + b"f 1/1 2/2 3\n",
        SQUARE + b"vt 0 nan\nf 1/1 2/1 3/1\n",
        SQUARE + b"vt 0 0\nvt 1\nf 1/1 2/2 3/1\n",
        SQUARE + b"vt 0 0\nf -4/-1 -3/-1 -2/-1\nvt 1 1\n",
        SQUARE + b"f 1/1 2/1 3/1\n",
    ],
)
def test_obj_uvs_that_are_amiss_are_left_out(parsed, text):
    mesh = parsed(text)
    assert mesh.triangles.tolist() == [[0, 1, 2]] and mesh.vertex_count == 4
    assert mesh.uvs is None


def test_obj_of_trimesh_brings_what_it_was_given(tmp_path):
    box = trimesh.creation.box()
    uvs = np.random.default_rng(0).random((8, 2)).round(6)
    box.visual = trimesh.visual.TextureVisuals(uv=uvs)
    text = trimesh.exchange.obj.export_obj(box, include_normals=True, include_texture=True)
    text = text[0] if isinstance(text, tuple) else text
    (tmp_path / "box.obj").write_text(text)
    mesh = read_mesh(tmp_path / "box.obj")
    assert np.array_equal(mesh.triangles, box.faces)
    assert np.abs(mesh.uvs - uvs).max() < 1e-6
    assert np.abs(mesh.normals - box.vertex_normals).max() < 1e-6


def test_obj_unused_points_and_colours_are_kept(parsed):
    mesh = parsed(b"v 0 0 0 1 0 0\nv 9 9 9 0 1 0\nv 1 0 0 0 0 1\nv 0 1 0 1 1 1\nf 1 3 4\n")
    assert mesh.positions[1].tolist() == [9, 9, 9]
    assert mesh.colours.tolist() == [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]]
    assert mesh.triangles.tolist() == [[0, 2, 3]]


def test_obj_lines_of_different_lengths_are_cut_to_the_shortest(parsed):
    mesh = parsed(b"v 0 0 0 1\nv 1 0 0\nv 0 1 0 1 1 1\nf 1 2 3\n")
    assert mesh.positions.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert mesh.colours is None


def test_obj_names_and_comments_may_be_in_any_encoding(parsed):
    mesh = parsed(b"# \xe4\no \xff\n" + SQUARE + b"g \xf6/1\nf 1 2 3\n")
    assert mesh.triangles.tolist() == [[0, 1, 2]]


@pytest.mark.parametrize("text", [b"# nothing\n", b"\n\n", b"o empty\n"])
def test_obj_without_points_is_an_empty_mesh(parsed, text):
    mesh = parsed(text)
    assert (mesh.vertex_count, mesh.triangle_count) == (0, 0)


@pytest.mark.parametrize(
    "text, message",
    [
        (SQUARE + b"f 1 2 5\n", "out of bounds"),
        (SQUARE + b"f 0 1 2\n", "faces: expected numbers from 1, got 0"),
        (SQUARE + b"f 1/1 2/1 0/1\n", "faces: expected numbers from 1, got 0"),
        (SQUARE + b"f -5 1 2\n", "out of bounds"),
        (SQUARE + b"f 1 2 x\n", "could not be read"),
        (SQUARE + b"f 1.5 2 3\n", "could not be read"),
        (b"v 0 0\nv 1 0\nf 1 2 1\n", r"points: expected \(n, 3\)"),
        (b"v 0 zero 0\n", "could not be read"),
        (b"<html>\n", "no mesh in it"),
        (b"f 1 2 3\n", "no mesh in it"),
    ],
)
def test_obj_faults_are_named(parsed, text, message):
    with pytest.raises(FileError, match=message):
        parsed(text)
