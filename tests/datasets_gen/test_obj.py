import numpy as np
import pytest

from lodbench.datasets_gen.obj import parse_obj
from tests.tolerances import UNIT_LENGTH

SQUARE = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
UVS = b"vt 0 0\nvt 1 0\nvt 1 1\nvt 0.5 0.5\n"
NORMALS = b"vn 0 0 1\nvn 0 0 2\nvn 0 1 0\n"


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
        b"o a\ng b c\ns off\nusemtl d\nf 1 2 3 # a comment\nmtllib e.mtl\nf 1 3 4\nl 1 2\n",
        UVS + NORMALS + b"f 1/1/1 2/2/1 3/3/1 4\n",
    ],
)
def test_obj_square_in_many_spellings(faces):
    mesh = parse_obj(b"# comment\n" + SQUARE + faces)
    assert mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert mesh.positions.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    assert mesh.uvs is None and mesh.normals is None


def test_obj_negative_index_counts_from_its_own_line():
    text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf -3 -2 -1\n"
    assert parse_obj(text).triangles.tolist() == [[0, 1, 2], [3, 4, 5]]


def test_obj_point_with_two_uvs_becomes_two_vertices():
    mesh = parse_obj(SQUARE + UVS + b"f 1/1 2/2 3/3\nf 1/4 3/3 4/1\n")
    assert mesh.triangles.tolist() == [[0, 1, 2], [4, 2, 3]]
    assert mesh.positions[4].tolist() == [0, 0, 0]
    assert mesh.uvs.tolist() == [[0, 0], [1, 0], [1, 1], [0, 0], [0.5, 0.5]]


def test_obj_point_with_two_normals_stays_one_vertex_with_their_mean():
    mesh = parse_obj(SQUARE + NORMALS + b"f 1//1 2//1 3//2\nf 1//3 3//2 4//3\n")
    assert mesh.vertex_count == 4
    half = 0.5**0.5
    expected = [(0, half, half), (0, 0, 1), (0, 0, 1), (0, 1, 0)]
    assert np.abs(mesh.normals - expected).max() < UNIT_LENGTH


def test_obj_unused_points_and_colours_are_kept():
    mesh = parse_obj(b"v 0 0 0 1 0 0\nv 9 9 9 0 1 0\nv 1 0 0 0 0 1\nv 0 1 0 1 1 1\nf 1 3 4\n")
    assert mesh.positions[1].tolist() == [9, 9, 9]
    assert mesh.colours.tolist() == [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]]
    assert mesh.triangles.tolist() == [[0, 2, 3]]


def test_obj_lines_of_different_lengths_are_cut_to_the_shortest():
    mesh = parse_obj(b"v 0 0 0 1\nv 1 0 0\nv 0 1 0 1 1 1\nf 1 2 3\n")
    assert mesh.positions.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert mesh.colours is None


@pytest.mark.parametrize("text", [b"# nothing\n", b"\n\n", b"o empty\n"])
def test_obj_without_points_is_an_empty_mesh(text):
    mesh = parse_obj(text)
    assert (mesh.vertex_count, mesh.triangle_count) == (0, 0)


@pytest.mark.parametrize(
    "text, message",
    [
        (SQUARE + b"f 1 2 5\n", r"faces: expected numbers up to \[4, 0, 0\], got \[5, 0, 0\]"),
        (SQUARE + b"f 0 1 2\n", "faces: expected numbers"),
        (SQUARE + b"f -5 1 2\n", "faces: expected numbers"),
        (SQUARE + b"f 1/1 2/1 3/1\n", "faces: expected numbers"),
        (SQUARE + UVS + b"f 1/9 2/1 3/1\n", "faces: expected numbers"),
        (SQUARE + UVS + b"f 1/-5 2/-1 3/-1\n", "faces: expected numbers"),
        (SQUARE + b"f 1 2 x\n", "expected"),
        (SQUARE + b"f 1/2/3/4 2 3\n", "expected corners"),
        (SQUARE + b"f 1.5 2 3\n", "expected"),
        (b"v 0 0\nv 1 0\nf 1 2 1\n", "three|3 numbers"),
        (b"v 0 zero 0\n", "expected numbers after 'v'"),
        (b"<html>\n", "no mesh in it"),
        (b"f 1 2 3\n", "faces: expected numbers"),
    ],
)
def test_obj_faults_are_named(text, message):
    with pytest.raises(ValueError, match=message):
        parse_obj(text)
