import errno
import io
import json
import os
import struct
import warnings
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen import read, triangles
from lodbench.datasets_gen.arrays import FAR
from lodbench.datasets_gen.read import (
    FileError,
    chain_bytes,
    check_writable,
    read_mesh,
    write_all,
    write_mesh,
)
from lodbench.datasets_gen.surfaces import ATTRIBUTES, TriangleMesh
from lodbench.datasets_gen.triangles import icosphere
from tests.datasets_gen.topology import soup, topology
from tests.tolerances import EPSILON32, ROUNDING32

NASTY_FILES = {
    # vertices, triangles
    "empty.obj": (0, 0),
    "empty.ply": (0, 0),
    "empty.stl": (0, 0),
    "negative_indices.obj": (None, 12),
    "polygonfaces.obj": (5, 3),
    "points_emptyface.ply": (1024, 0),
    "degenerate_mesh.obj": (3, 1),
    "deg_faces.obj": (None, 4),
    "extra_vertex.obj": (None, 3),
    "two_faces_123.obj": (6, 2),
}
NASTY_CASES = {
    "nan_vertex": "points: expected finite",
    "index_out_of_range": "faces: expected indices",
    "index_negative": "faces: expected indices",
}


@pytest.fixture
def rich():
    """A mesh with every attribute; colours are whole bytes, so that 8-bit formats keep them."""
    mesh = triangles.terrain(6)
    random = np.random.default_rng(0)
    colours = random.integers(0, 256, (mesh.vertex_count, 3)) / 255
    tags = random.random((mesh.vertex_count, 3))
    return TriangleMesh(mesh.positions, mesh.triangles, mesh.normals, mesh.uvs, colours, tags)


def one_line(call, *arguments):
    with pytest.raises(FileError) as caught:
        call(*arguments)
    text = str(caught.value)
    assert "\n" not in text and len(text) < 700
    return text


def near(a, b):
    return (a is None) == (b is None) and (a is None or np.abs(a - b).max() <= ROUNDING32)


@pytest.mark.parametrize(
    "suffix, kept",
    [
        (".ply", ("normals", "uvs", "colours", "tags")),
        (".obj", ("normals", "uvs", "colours")),
        (".off", ()),
        (".gltf", ("normals", "uvs", "colours")),
        (".glb", ("normals", "uvs", "colours")),
    ],
)
def test_round_trip_keeps_order_and_what_the_format_carries(tmp_path, rich, suffix, kept):
    path = tmp_path / f"mesh{suffix}"
    write_mesh(path, rich)
    result = read_mesh(path)
    assert np.array_equal(result.positions, rich.positions)
    assert np.array_equal(result.triangles, rich.triangles)
    for name in ATTRIBUTES:
        expected = getattr(rich, name) if name in kept else None
        assert near(getattr(result, name), expected), name
    assert os.listdir(tmp_path) == [path.name]


@pytest.mark.parametrize("suffix", [".gltf", ".glb"])
def test_gltf_is_written_with_its_normals(tmp_path, rich, suffix):
    path = tmp_path / f"mesh{suffix}"
    write_mesh(path, rich)
    (shape,) = trimesh.load_scene(path, process=False).geometry.values()
    assert near(shape.vertex_normals, rich.normals)


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".gltf", ".glb"])
@pytest.mark.parametrize("kept", ["normals", "uvs", "colours"])
def test_one_attribute_alone_is_kept(tmp_path, rich, suffix, kept):
    alone = TriangleMesh(rich.positions, rich.triangles, **{kept: getattr(rich, kept)})
    write_mesh(tmp_path / f"mesh{suffix}", alone)
    result = read_mesh(tmp_path / f"mesh{suffix}")
    assert np.array_equal(result.triangles, rich.triangles)
    for name in ATTRIBUTES:
        assert near(getattr(result, name), getattr(alone, name)), name


def test_stl_round_trip_keeps_the_triangles_and_welds_them(tmp_path):
    mesh = triangles.icosphere(2)
    write_mesh(tmp_path / "mesh.STL", mesh)
    result = read_mesh(tmp_path / "mesh.STL")
    assert np.array_equal(soup(result), soup(mesh))
    assert topology(result) == topology(mesh)


@pytest.mark.parametrize("suffix", read.SUFFIXES)
def test_no_triangles_out_no_triangles_in(tmp_path, suffix):
    path = tmp_path / f"mesh{suffix}"
    for points in (np.zeros((0, 3)), np.eye(3)):
        write_mesh(path, TriangleMesh(points, np.zeros((0, 3), np.uint32)))
        result = read_mesh(path)
        assert result.triangle_count == 0
        if suffix in (".ply", ".obj", ".off"):
            assert np.array_equal(result.positions, points)


@pytest.mark.parametrize("suffix", read.SUFFIXES)
def test_trimesh_reads_what_is_written(tmp_path, suffix):
    mesh = triangles.torus(8, 5)
    path = tmp_path / f"mesh{suffix}"
    write_mesh(path, TriangleMesh(mesh.positions, mesh.triangles))
    seen = trimesh.load_mesh(path, process=False)
    assert np.allclose(np.asarray(seen.triangles).reshape(-1, 9), soup(mesh), atol=1e-6)


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".off", ".glb"])
@pytest.mark.parametrize("scale", [1e-30, 1.0, 1e30])
def test_round_trip_is_exact_at_every_scale(tmp_path, suffix, scale):
    mesh = triangles.icosphere(1)
    scaled = TriangleMesh(mesh.positions * np.float32(scale), mesh.triangles)
    write_mesh(tmp_path / f"mesh{suffix}", scaled)
    assert np.array_equal(read_mesh(tmp_path / f"mesh{suffix}").positions, scaled.positions)


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".off", ".stl"])
@settings(
    max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_any_mesh_survives_a_round_trip(tmp_path, suffix, data):
    floats = st.floats(width=32, allow_nan=False, allow_infinity=False)
    points = data.draw(st.lists(st.tuples(floats, floats, floats), max_size=6))
    index = st.integers(0, max(len(points) - 1, 0))
    faces = data.draw(st.lists(st.tuples(index, index, index), max_size=6)) if points else []
    mesh = TriangleMesh(
        np.array(points, np.float32).reshape(-1, 3), np.array(faces, np.uint32).reshape(-1, 3)
    )
    write_mesh(tmp_path / f"mesh{suffix}", mesh)
    result = read_mesh(tmp_path / f"mesh{suffix}")
    points = result.points.astype(np.float32)  # text read as float64 may end in other digits
    assert np.array_equal(points[result.triangles], mesh.positions[mesh.triangles])
    if suffix != ".stl":
        assert np.array_equal(points, mesh.positions)
        assert np.array_equal(result.triangles, mesh.triangles)


@pytest.mark.parametrize("suffix", read.SUFFIXES)
@settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_damaged_files_end_in_a_mesh_or_one_line(tmp_path, suffix, data):
    path = tmp_path / f"mesh{suffix}"
    if not path.exists():
        write_mesh(path, triangles.plane(2))
    whole = path.read_bytes()
    start = data.draw(st.integers(0, len(whole) - 1))
    end = data.draw(st.integers(start, min(len(whole), start + 8)))
    damaged = tmp_path / f"damaged{suffix}"
    damaged.write_bytes(whole[:start] + data.draw(st.binary(max_size=8)) + whole[end:])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            assert isinstance(read_mesh(damaged), TriangleMesh)
        except FileError as error:
            assert "\n" not in str(error)


@pytest.mark.parametrize("suffix", [".ply", ".stl", ".glb", ".off", ".gltf"])
def test_truncated_file_is_refused_wherever_it_ends(tmp_path, suffix):
    path = tmp_path / f"mesh{suffix}"
    write_mesh(path, triangles.plane(3))
    whole = path.read_bytes().rstrip()  # white space at the end may go
    for length in {1, 10, 80, 84, 100, len(whole) // 3, len(whole) // 2, len(whole) - 50}:
        path.write_bytes(whole[:length])
        one_line(read_mesh, path)
    if suffix != ".off":  # the last digits of a text may go unnoticed
        path.write_bytes(whole[:-1])
        one_line(read_mesh, path)


def test_truncated_ascii_stl_is_refused(tmp_path):
    path = tmp_path / "mesh.stl"
    facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    whole = f"solid a\n{facet}{facet}endsolid a\n"
    path.write_text(whole)
    assert (read_mesh(path).vertex_count, read_mesh(path).triangle_count) == (3, 2)
    for length in (60, len(whole) // 2, len(whole) - 12):
        path.write_text(whole[:length])
        assert "truncated" in one_line(read_mesh, path)
    path.write_text(whole.replace("vertex 1 0 0", "vertex 1 zero 0"))
    one_line(read_mesh, path)


@pytest.mark.parametrize("suffix", read.SUFFIXES)
def test_wrong_content_is_refused(tmp_path, suffix):
    path = tmp_path / f"mesh{suffix}"
    for content in (b"", b"<html>not found</html>\n", bytes(range(256)), b"ply\n"):
        path.write_bytes(content)
        assert str(path) in one_line(read_mesh, path)


def test_missing_file_folder_and_suffix_are_told_apart(tmp_path):
    assert "no such file" in one_line(read_mesh, tmp_path / "none.ply")
    (tmp_path / "folder.ply").mkdir()
    assert "got a folder" in one_line(read_mesh, tmp_path / "folder.ply")
    assert "expected a suffix of .ply" in one_line(read_mesh, tmp_path / "mesh.blend")
    assert "got none" in one_line(read_mesh, tmp_path / "mesh")


@pytest.mark.parametrize("suffix", [".obj", ".off", ".ply"])
@pytest.mark.parametrize("word", ["nan", "inf", "1e39"])
def test_points_that_are_no_float32_are_refused(tmp_path, suffix, word):
    path = tmp_path / f"mesh{suffix}"
    text = {
        ".obj": f"v 0 0 0\nv 1 0 {word}\nv 0 1 0\nf 1 2 3\n",
        ".off": f"OFF\n3 1 0\n0 0 0\n1 0 {word}\n0 1 0\n3 0 1 2\n",
        ".ply": "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        f"0 0 0\n1 0 {word}\n0 1 0\n3 0 1 2\n",
    }[suffix]
    path.write_text(text)
    assert "points: expected finite float32 values" in one_line(read_mesh, path)


def test_off_polygons_comments_and_colours_are_read(tmp_path):
    path = tmp_path / "mesh.off"
    path.write_text(
        "COFF # a comment\n\n4 2 0\n0 0 0 255 0 0 1\n1 0 0 1 1 1 1\n1 1 0 1 1 1 1\n0 1 0 1 1 1 1\n"
        "4 0 1 2 3 255 0 0\n3 0 1 2\n"
    )
    mesh = read_mesh(path)
    assert sorted(map(sorted, mesh.triangles.tolist())) == [[0, 1, 2], [0, 1, 2], [0, 2, 3]]
    assert mesh.positions[2].tolist() == [1, 1, 0]
    path.write_text("OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n4 0 1 2")
    assert "truncated" in one_line(read_mesh, path)
    path.write_text("OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n")
    assert "index" in one_line(read_mesh, path)


def test_gltf_scene_is_joined_in_place(tmp_path):
    box = trimesh.creation.box()
    scene = trimesh.Scene()
    scene.add_geometry(
        box, node_name="a", transform=trimesh.transformations.translation_matrix([5, 0, 0])
    )
    mirror = np.diag([-1.0, 2.0, 1.0, 1.0])
    scene.add_geometry(box, node_name="b", transform=mirror)
    (tmp_path / "scene.glb").write_bytes(scene.export(file_type="glb"))
    mesh = read_mesh(tmp_path / "scene.glb")
    found = topology(mesh)
    assert mesh.triangle_count == 24
    assert found.volume == pytest.approx(1 + 2)  # the mirrored box is turned right side out
    assert mesh.box[1].tolist() == [5.5, 1.0, 0.5]


def test_gltf_finds_the_files_beside_it(tmp_path, monkeypatch):
    (tmp_path / "folder").mkdir()
    for name, data in trimesh.exchange.gltf.export_gltf(trimesh.creation.box().scene()).items():
        (tmp_path / "folder" / name).write_bytes(data)
    monkeypatch.chdir(tmp_path)
    assert read_mesh("folder/model.gltf").triangle_count == 12
    for buffer in (tmp_path / "folder").glob("*.bin"):
        buffer.unlink()
    one_line(read_mesh, "folder/model.gltf")


def test_glb_declared_longer_than_the_file_is_truncated(tmp_path):
    path = tmp_path / "mesh.glb"
    path.write_bytes(b"glTF" + struct.pack("<II", 2, 1000) + b"\0" * 8)
    assert "truncated: expected 1000 bytes, got 20" in one_line(read_mesh, path)


@pytest.mark.parametrize("name", NASTY_FILES)
def test_nasty_file_is_read(data_folder, name):
    mesh = read_mesh(data_folder / "nasty" / "formats" / name)
    vertices, count = NASTY_FILES[name]
    assert mesh.triangle_count == count
    assert vertices is None or mesh.vertex_count == vertices


def test_every_real_mesh_is_read_as_declared(data_folder):
    from lodbench.datasets_gen.ply import ply_counts

    for path in sorted(data_folder.glob("*/*.ply")):
        mesh = read_mesh(path)
        assert (mesh.vertex_count, mesh.triangle_count) == ply_counts(path.read_bytes()), path


def test_every_synthetic_case_is_a_mesh_or_one_line(data_folder, tmp_path):
    with np.load(data_folder / "nasty" / "synthetic.npz") as cases:
        for name in {key.rsplit("__", 1)[0] for key in cases}:
            points, faces = cases[f"{name}__V"], cases[f"{name}__F"]
            if name in NASTY_CASES:
                with pytest.raises(ValueError, match=NASTY_CASES[name]):
                    TriangleMesh(points, faces)
                continue
            mesh = TriangleMesh(points, faces)
            write_mesh(tmp_path / "case.ply", mesh)
            assert np.array_equal(read_mesh(tmp_path / "case.ply").positions, mesh.positions)


def test_unwritable_paths_are_refused_before_the_work(tmp_path):
    assert "no such folder" in one_line(check_writable, tmp_path / "none" / "mesh.ply")
    assert "expected a suffix" in one_line(check_writable, tmp_path / "mesh.xyz")
    (tmp_path / "folder.ply").mkdir()
    assert "got a folder" in one_line(check_writable, tmp_path / "folder.ply")
    (tmp_path / "file").write_text("")
    assert "no such folder" in one_line(check_writable, tmp_path / "file" / "mesh.ply")
    os.mkfifo(tmp_path / "pipe.ply")
    assert "a device" in one_line(check_writable, tmp_path / "pipe.ply")
    check_writable(tmp_path / "mesh.ply")
    assert not (tmp_path / "mesh.ply").exists()
    assert "cannot be written" in one_line(check_writable, "/proc/mesh.ply")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_read_only_folder_and_file_are_refused(tmp_path):
    path = tmp_path / "mesh.ply"
    path.write_text("kept")
    path.chmod(0o400)
    assert "read-only" in one_line(check_writable, path)
    path.chmod(0o600)
    tmp_path.chmod(0o500)
    try:
        assert "cannot be written" in one_line(check_writable, path)
    finally:
        tmp_path.chmod(0o700)


def test_failed_write_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "mesh.ply"
    write_mesh(path, triangles.plane(1))
    before = path.read_bytes()

    def full(descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    assert "No space left" in one_line(write_mesh, path, triangles.plane(9))
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["mesh.ply"]


def test_interrupted_write_leaves_the_old_file(tmp_path):
    path = tmp_path / "mesh.ply"
    path.write_text("kept")
    with pytest.raises(KeyboardInterrupt), read.replacing(path) as stream:
        stream.write(b"half")
        raise KeyboardInterrupt
    assert path.read_text() == "kept"
    assert os.listdir(tmp_path) == ["mesh.ply"]


def test_write_goes_through_a_link_and_keeps_the_mode(tmp_path):
    target = tmp_path / "target.ply"
    target.write_text("old")
    target.chmod(0o640)
    link = tmp_path / "link.ply"
    link.symlink_to(target)
    write_mesh(link, triangles.plane(1))
    assert link.is_symlink()
    assert read_mesh(target).triangle_count == 2
    assert target.stat().st_mode & 0o777 == 0o640


def test_reading_prints_and_logs_nothing(tmp_path, capfd, caplog):
    (tmp_path / "mesh.stl").write_bytes(b"solid\n" + b"\xff" * 200)
    (tmp_path / "mesh.gltf").write_text('{"asset": {"version": "2.0"}, "meshes": [{}]}')
    for name in ("mesh.stl", "mesh.gltf"):
        one_line(read_mesh, tmp_path / name)
    # a broken normal is passed over, not without a word from trimesh
    (tmp_path / "mesh.stl").write_text(
        "solid a\nfacet normal up\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
        "endfacet\nendsolid a\n"
    )
    assert read_mesh(tmp_path / "mesh.stl").triangle_count == 1
    assert capfd.readouterr() == ("", "")
    assert not caplog.records


MAP = np.array((4e5, 5e6, 100.0))


def by_place(mesh):
    """The corners of the triangles in the world, about the first: (m, 3, 3)."""
    return mesh.points[mesh.triangles] - MAP


@pytest.mark.parametrize("suffix", read.SUFFIXES)
def test_map_coordinates_keep_their_shape(tmp_path, suffix):
    near = triangles.torus(24, 12)
    far = TriangleMesh(near.positions + MAP, near.triangles)
    write_mesh(tmp_path / f"mesh{suffix}", far)
    result = read_mesh(tmp_path / f"mesh{suffix}")
    assert np.abs(by_place(result) - near.positions[near.triangles]).max() <= 1e-6
    assert np.array_equal(by_place(result), by_place(far)), "written and read to the bit"


@pytest.mark.parametrize("suffix", [".obj", ".off", ".ply"])
def test_digits_of_a_text_are_read_as_they_are(tmp_path, suffix):
    points = MAP + np.random.default_rng(1).random((4, 3))
    rows = [" ".join(f"{number:.12f}" for number in row) for row in points]
    header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\n"
    header += "property double z\nelement face 1\nproperty list uchar int vertex_indices\n"
    text = {
        ".obj": "".join(f"v {row}\n" for row in rows) + "f 1 2 3\n",
        ".off": "OFF\n4 1 0\n" + "\n".join(rows) + "\n3 0 1 2\n",
        ".ply": header + "end_header\n" + "\n".join(rows) + "\n3 0 1 2\n",
    }
    (tmp_path / f"mesh{suffix}").write_text(text[suffix])
    assert np.abs(read_mesh(tmp_path / f"mesh{suffix}").points - points).max() <= 1e-7


@pytest.mark.parametrize("suffix", read.SUFFIXES)
@settings(
    max_examples=10, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_any_float64_mesh_survives_a_round_trip(tmp_path, suffix, data):
    number = st.floats(-1, 1)
    points = data.draw(st.lists(st.tuples(number, number, number), min_size=3, max_size=6))
    offset = data.draw(st.tuples(*3 * [st.floats(-1e9, 1e9)]))
    mesh = TriangleMesh(np.array(points) + offset, [(0, 1, 2), (2, 1, 0)])
    write_mesh(tmp_path / f"mesh{suffix}", mesh)
    result = read_mesh(tmp_path / f"mesh{suffix}")
    difference = result.points[result.triangles] - mesh.points[mesh.triangles]
    # points that no triangle uses may be left out, and the origin moves
    assert np.abs(difference).max() <= FAR * EPSILON32 * mesh.diagonal


def test_degenerate_facets_far_from_zero_are_written_as_stl(tmp_path):
    mesh = TriangleMesh(np.eye(3) * 0.1 + MAP, [(0, 1, 2), (0, 0, 1)])
    write_mesh(tmp_path / "mesh.stl", mesh)
    assert read_mesh(tmp_path / "mesh.stl").triangle_count == 2


def test_levels_in_glb_are_lower_nodes_of_the_first(tmp_path):
    levels = [icosphere(k).with_origin(np.array((1e6, 0, 3))) for k in (2, 1, 0)]
    nothing = TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int))
    data = chain_bytes([*levels, nothing], ".glb")
    length = int.from_bytes(data[12:16], "little")
    tree = json.loads(data[20 : 20 + length])
    assert tree["extensionsUsed"] == ["MSFT_lod"]
    assert [node.get("extensions") for node in tree["nodes"]] == [
        {"MSFT_lod": {"ids": [1, 2]}}, None, None,
    ]  # fmt: skip
    assert tree["scenes"][0]["nodes"] == [0]
    counts = [
        tree["accessors"][tree["meshes"][node["mesh"]]["primitives"][0]["indices"]]["count"] // 3
        for node in tree["nodes"]
    ]
    assert counts == [level.triangle_count for level in levels]
    path = tmp_path / "levels.glb"
    path.write_bytes(data)
    found = read_mesh(path)
    assert np.array_equal(found.triangles, levels[0].triangles)
    assert np.abs(found.points - levels[0].points).max() < 1e-6
    assert len(trimesh.load_scene(path).geometry) == 3
    assert chain_bytes(levels, ".ply") is None
    alone = json.loads(chain_bytes(levels[:1], ".gltf"))
    assert "extensionsUsed" not in alone


def test_several_files_are_written_or_none(tmp_path, monkeypatch):
    paths = [tmp_path / f"{k}.ply" for k in range(3)]
    write_all({path: b"old" for path in paths})

    class Full(io.RawIOBase):
        def writable(self):
            return True

        def write(self, data):
            raise OSError(errno.ENOSPC, "No space left on device")

    opened = Path.open

    def last_is_full(self, *words, **options):
        return Full() if "2.ply" in self.name else opened(self, *words, **options)

    monkeypatch.setattr(Path, "open", last_is_full)
    with pytest.raises(FileError, match=r"2\.ply: cannot be written: No space"):
        write_all({path: b"new" for path in paths})
    monkeypatch.undo()
    assert [path.read_bytes() for path in paths] == 3 * [b"old"]
    assert len(list(tmp_path.iterdir())) == 3
