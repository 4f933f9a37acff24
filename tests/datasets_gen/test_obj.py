import numpy as np
import pytest

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


def test_obj_point_with_several_uvs_and_normals_stays_one_vertex(parsed):
    mesh = parsed(SQUARE + UVS + NORMALS + b"f 1/1/1 2/2/1 3/3/2\nf 1/4/3 3/3/2 4/1/3\n")
    assert mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert mesh.vertex_count == 4


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
