import numpy as np
import pytest

from lodbench.datasets_gen import batches, read
from lodbench.datasets_gen.batches import MeshFile
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import torus

COORDINATES = ("float", "double")


def ply_of(mesh, order="little", kind="float", index="int", more=(), faces_first=False):
    """A binary PLY file of a mesh, with further properties `more` around the coordinates."""
    sign = "<" if order == "little" else ">"
    codes = {"float": "f4", "double": "f8", "int": "i4", "uint": "u4", "short": "i2", "uchar": "u1"}
    names = [*more[:1], "x", "y", "z", *more[1:]]
    kinds = [kind if name in "xyz" else "uchar" for name in names]
    vertices = np.zeros(
        mesh.vertex_count, [(n, sign + codes[k]) for n, k in zip(names, kinds, strict=True)]
    )
    for axis, values in zip("xyz", mesh.points.T, strict=True):
        vertices[axis] = values
    faces = np.zeros(
        mesh.triangle_count, [("n", "u1"), ("v", sign + codes[index], 3), ("flag", "u1")]
    )
    faces["n"], faces["v"] = 3, mesh.triangles
    head = [
        [
            f"element vertex {len(vertices)}",
            *(f"property {k} {n}" for n, k in zip(names, kinds, strict=True)),
        ],
        [
            f"element face {len(faces)}",
            f"property list uchar {index} vertex_indices",
            "property uchar flag",
        ],
    ]
    body = [vertices.tobytes(), faces.tobytes()]
    if faces_first:
        head, body = head[::-1], body[::-1]
    lines = ["ply", f"format binary_{order}_endian 1.0", *head[0], *head[1], "end_header", ""]
    return "\n".join(lines).encode() + body[0] + body[1]


def scattered(mesh, seed=0):
    """The same triangles with their order and that of the points shuffled."""
    random = np.random.default_rng(seed)
    order, rows = random.permutation(mesh.vertex_count), random.permutation(mesh.triangle_count)
    number = np.empty_like(order)
    number[order] = np.arange(len(order))
    return TriangleMesh(mesh.points[order], number[mesh.triangles[rows]])


def corners(file, *range_, **options):
    """Corner positions of all triangles of the file's batches, (m, 3, 3)."""
    found = [b.positions[b.triangles] for b in file.batches(*range_, **options)]
    return np.concatenate(found)


@pytest.mark.parametrize("window", [1, 1 << 20])
@pytest.mark.parametrize("mesh", [torus(40, 30), scattered(torus(40, 30))], ids=["local", "far"])
@pytest.mark.parametrize(
    "options",
    [
        {},
        {"kind": "double"},
        {"order": "big", "index": "uint"},
        {"order": "big", "kind": "double", "more": ("flag", "red", "green"), "index": "short"},
        {"faces_first": True},
    ],
    ids=str,
)
def test_batches_are_the_triangles_of_the_mesh_as_it_is_read(tmp_path, mesh, options, window):
    (tmp_path / "a.ply").write_bytes(ply_of(mesh, **options))
    whole, file = read.read_mesh(tmp_path / "a.ply"), MeshFile(tmp_path / "a.ply", window)
    low, high = file.box()
    assert np.array_equal([low, high], whole.box)
    assert np.array_equal(np.concatenate(list(file.positions())), whole.positions)
    expected = whole.positions[whole.triangles]
    assert np.array_equal(corners(file, 0, 2400, rows=333), expected)
    assert np.array_equal(corners(file, 100, 1200, rows=64), expected[100:1200])
    assert np.array_equal(corners(file, 0, 2400, rows=100, stride=7), expected[::7])


def test_stl_is_a_soup_of_the_same_corners(tmp_path):
    read.write_mesh(tmp_path / "a.stl", torus(20, 10))
    whole, file = read.read_mesh(tmp_path / "a.stl"), MeshFile(tmp_path / "a.stl")
    assert np.array_equal(file.box(), whole.box)
    assert (file.vertex_count, file.triangle_count) == (1200, 400)
    expected = whole.positions[whole.triangles]
    assert np.array_equal(np.concatenate(list(file.positions())), expected.reshape(-1, 3))
    assert np.array_equal(corners(file, 0, 400, rows=30, stride=7), expected[::7])


@pytest.mark.parametrize("kind", COORDINATES)
def test_far_coordinates_have_the_origin_of_the_mesh(tmp_path, kind):
    mesh = torus(20, 10)
    far = TriangleMesh(mesh.positions + np.array([4e5, -3e6, 12.0]), mesh.triangles)
    (tmp_path / "a.ply").write_bytes(ply_of(far, kind=kind))
    whole, file = read.read_mesh(tmp_path / "a.ply"), MeshFile(tmp_path / "a.ply")
    assert np.array_equal(file.box(), whole.box)
    assert (file.origin is None) == (kind == "float") == (whole.origin is None)
    assert file.origin is None or np.array_equal(file.origin, whole.origin)
    assert np.array_equal(np.concatenate(list(file.positions())), whole.positions)


def with_a_quad(data):
    at = data.index(b"end_header\n") + 11 + 12 * 200
    return data[:at] + b"\x04" + data[at + 1 :]


@pytest.mark.parametrize(
    ("name", "data", "reason"),
    [
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 0\nend_header\n", "binary PLY, got text"),
        ("a.obj", b"v 0 0 0\n", "a whole binary file of PLY or STL"),
        ("a.stl", b"solid\nendsolid\n" + 80 * b" ", "a whole binary file of PLY or STL"),
        ("a.ply", ply_of(torus(20, 10))[:-1], "truncated: expected"),
        (
            "a.ply",
            ply_of(torus(20, 10)).replace(b"float y", b"int32 y"),
            "x, y, z of one kind, float or double",
        ),
        (
            "a.ply",
            ply_of(torus(20, 10)).replace(b"vertex_indices", b"texture_coords"),
            "vertex_indices, got texture_coords",
        ),
        ("a.ply", b"ply\nformat binary_little_endian 1.0\nend_header\n", "vertices and faces"),
    ],
)
def test_what_cannot_be_streamed_is_refused_in_one_line(tmp_path, name, data, reason):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(read.FileError, match=reason) as error:
        MeshFile(tmp_path / name)
    assert "\n" not in str(error.value)


def test_polygons_and_indices_out_of_range_are_refused_where_they_stand(tmp_path):
    mesh = torus(20, 10)
    (tmp_path / "a.ply").write_bytes(with_a_quad(ply_of(mesh)))
    with pytest.raises(read.FileError, match="triangles alone, got 4 corners in face 0"):
        list(MeshFile(tmp_path / "a.ply").batches(0, 400, 100))
    data = bytearray(ply_of(mesh))
    data[-5:-1] = np.int32(200).tobytes()
    (tmp_path / "a.ply").write_bytes(data)
    with pytest.raises(ValueError, match="faces: expected indices from 0 to 199, got 200"):
        list(MeshFile(tmp_path / "a.ply").batches(0, 400, 100))


def test_values_that_are_not_finite_are_named(tmp_path):
    mesh = torus(20, 10)
    data = bytearray(ply_of(mesh))
    at = data.index(b"end_header\n") + 11 + 12 * 7
    data[at : at + 4] = np.float32(np.nan).tobytes()
    (tmp_path / "a.ply").write_bytes(data)
    with pytest.raises(ValueError, match=r"finite float32 values, got .*nan.* in row 7"):
        MeshFile(tmp_path / "a.ply").box()


def test_ahead_gives_the_same_in_order_and_hands_errors_on():
    assert list(batches.ahead(iter(range(9)))) == list(range(9))
    with pytest.raises(ZeroDivisionError):
        list(batches.ahead(1 / n for n in (1, 0)))
    assert list(batches.pieces(7, 3)) == [(0, 3), (3, 6), (6, 7)]
