import numpy as np
import pytest

from lodbench.datasets_gen import triangles
from lodbench.datasets_gen.ply import parse_ply, ply_counts, ply_file

POINTS = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"


def header(vertices, faces, *, form="ascii", extra_vertex="", before="", after=""):
    return (
        f"ply\nformat {form} 1.0\ncomment made here\nelement vertex {vertices}\n"
        f"property float x\nproperty float y\nproperty float z\n{extra_vertex}"
        f"element face {faces}\n{before}property list uchar int vertex_indices\n{after}end_header\n"
    )


def test_ply_ascii_polygons_become_fans():
    mesh = parse_ply((header(4, 3) + POINTS + "4 0 1 2 3\n3 0 1 2\n2 0 1\n").encode())
    assert mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 2]]


@pytest.mark.parametrize(
    "kind, full", [("uchar", "255"), ("ushort", "65535"), ("float", "1"), ("double", "1.0")]
)
def test_ply_colours_are_shares_of_what_their_type_holds(kind, full):
    names = "".join(f"property {kind} {name}\n" for name in ("red", "green", "blue"))
    rows = [f"{point} 0 {full} {full}\n" for point in POINTS.splitlines()]
    mesh = parse_ply((header(4, 0, extra_vertex=names) + "".join(rows)).encode())
    assert mesh.colours.tolist() == [[0, 1, 1]] * 4


@pytest.mark.parametrize("order, form", [("<", "binary_little_endian"), (">", "binary_big_endian")])
def test_ply_binary_of_both_byte_orders_with_mixed_polygons_and_more_columns(order, form):
    text = header(
        4, 3, form=form,
        extra_vertex="property uchar red\nproperty uchar green\nproperty uchar blue\n",
        before="property uchar intensity\n", after="property float quality\n",
    )  # fmt: skip
    points = np.zeros(4, [("p", order + "f4", 3), ("c", "u1", 3)])
    points["p"] = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    points["c"] = (255, 0, 51)
    body = points.tobytes()
    for corners in ([0, 1, 2], [0, 1, 2, 3], [2, 1, 0]):
        body += b"\x07" + bytes([len(corners)]) + np.array(corners, order + "i4").tobytes()
        body += np.array([0.5], order + "f4").tobytes()
    mesh = parse_ply(text.encode() + body)
    assert mesh.triangles.tolist() == [[0, 1, 2], [0, 1, 2], [0, 2, 3], [2, 1, 0]]
    assert mesh.positions[2].tolist() == [1, 1, 0]
    assert mesh.colours[0] == pytest.approx([1, 0, 0.2])
    for length in range(len(text), len(text) + len(body)):
        with pytest.raises(ValueError, match="truncated"):
            parse_ply((text.encode() + body)[:length])


def test_ply_ascii_truncated_anywhere_is_refused():
    whole = header(4, 2) + POINTS + "3 0 1 2\n3 0 2 3"
    for words in range(1, 21):
        with pytest.raises(ValueError, match="truncated"):
            parse_ply(whole.rsplit(None, words)[0].encode() if words < 20 else b"ply\n")


@pytest.mark.parametrize(
    "text, message",
    [
        ("plx\n", "no 'ply'"),
        ("ply\nformat ascii 1.0\n", "truncated"),
        ("ply\nformat ascii 2.0\nelement vertex many\nend_header\n", "header line"),
        ("ply\nformat ascii 2.0\nproperty float x\nend_header\n", "header line"),
        ("ply\nformat zip 1.0\nend_header\n", "format"),
        ("ply\nformat ascii 1.0\nend_header\n", "no mesh in it"),
        ("ply\nformat ascii 1.0\nelement vertex -1\nproperty float x\nend_header\n", "header line"),
        (header(4, 1) + POINTS + "3 0 1 4\n", "faces: expected indices from 0 to 3, got 4"),
        (header(4, 1) + POINTS + "3 0 1 -1\n", "faces: expected indices from 0 to 3, got -1"),
        (header(4, 1) + POINTS + "3 0 one 2\n", "expected numbers"),
        (
            header(4, 1).replace("vertex_indices", "corners") + POINTS + "3 0 1 2\n",
            "vertex_indices",
        ),
        (header(4, 1).replace("face", "tristrips") + POINTS + "3 0 1 2\n", "triangle strips"),
    ],
)
def test_ply_faults_are_named(text, message):
    with pytest.raises(ValueError, match=message):
        parse_ply(text.encode())


def test_ply_counts_reads_the_header_alone():
    data = ply_file(triangles.plane(3))
    assert ply_counts(data[:400]) == (16, 18)


def test_ply_elements_may_come_in_any_order():
    text = (
        "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_index\n"
        "element camera 1\nproperty float f\nelement vertex 3\nproperty double x\nproperty double y\n"
        "property double z\nend_header\n3 2 1 0\n35\n0 0 0\n1 0 0\n0 1 0\n"
    )
    mesh = parse_ply(text.encode())
    assert mesh.triangles.tolist() == [[2, 1, 0]]


def polygons(form, corners):
    """A PLY file of fifteen points and these polygons."""
    text = header(15, len(corners), form=form)
    points = np.zeros((15, 3))
    if form == "ascii":
        rows = [*points.tolist(), *([len(row), *row] for row in corners)]
        return (text + "".join(" ".join(map(str, row)) + "\n" for row in rows)).encode()
    faces = [bytes([len(row)]) + np.array(row, "<i4").tobytes() for row in corners]
    return text.encode() + points.astype("<f4").tobytes() + b"".join(faces)


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian"])
def test_ply_polygons_of_all_sizes_become_fans_in_their_order(form):
    corners = [[0, 1, 2], [], [3, 4, 5, 6, 7], [8], [9, 10], [11, 12, 13, 14], [0, 2, 4]]
    expected = [[0, 1, 2], [3, 4, 5], [3, 5, 6], [3, 6, 7], [11, 12, 13], [11, 13, 14], [0, 2, 4]]
    assert parse_ply(polygons(form, corners)).triangles.tolist() == expected
    assert parse_ply(polygons(form, corners[1:2])).triangle_count == 0


def test_ply_tags_are_told_by_their_names_whatever_their_order():
    names = "".join(f"property float {name}\n" for name in ("sharpness", "bias", "tension"))
    rows = [f"{point} 0.5 -1 0.25\n" for point in POINTS.splitlines()]
    mesh = parse_ply((header(4, 0, extra_vertex=names) + "".join(rows)).encode())
    assert mesh.tags.tolist() == [[0.25, 0.5, -1]] * 4
    assert parse_ply(ply_file(mesh)).tags.tolist() == mesh.tags.tolist()
