import json
import struct
import warnings

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen import read, triangles
from lodbench.datasets_gen.contents import extras, format_of
from lodbench.datasets_gen.formats import CARRIED
from lodbench.datasets_gen.images import geometry_image_bytes
from lodbench.datasets_gen.read import FileError, mesh_bytes, parse_mesh, read_mesh
from lodbench.datasets_gen.surfaces import GeometryImage, TriangleMesh

TORUS = triangles.torus(8, 5)
FAR = TriangleMesh(TORUS.positions + np.array((4e5, 5e6, 0.1)), TORUS.triangles)


def found(tmp_path, name, data):
    """What is in a file, once it has been read."""
    path = tmp_path / name
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    read_mesh(path)
    return extras(path.read_bytes(), path)


@pytest.mark.parametrize("suffix", read.SUFFIXES)
@pytest.mark.parametrize("mesh", [TORUS, FAR], ids=["near", "far"])
def test_format_is_told_from_the_bytes(suffix, mesh):
    assert format_of(mesh_bytes(mesh, suffix)) == suffix


def test_formats_of_other_programs_are_told_too():
    image = GeometryImage(np.zeros((3, 3, 3)), np.zeros((3, 3, 3)))
    assert format_of(geometry_image_bytes(image)) == ".npz"
    assert format_of(b"# made by\n# hand\nSTOFF\n0 0 0\n") == ".off"
    assert format_of(b"solid a binary file\0".ljust(80) + struct.pack("<I", 0)) == ".stl"
    assert format_of(b"\n\nmtllib a.mtl\no a\n  v 0 0 0\n") == ".obj"
    for other in (b"", b"hello", bytes(range(256)), b"\x89PNG\r\n"):
        assert format_of(other) is None


@pytest.mark.parametrize("suffix", read.SUFFIXES)
def test_own_files_have_what_was_written(tmp_path, suffix):
    mesh = triangles.terrain(6)
    every = np.abs(mesh.positions % 1)
    rich = TriangleMesh(mesh.positions, mesh.triangles, mesh.normals, mesh.uvs, every, every)
    there = found(tmp_path, f"mesh{suffix}", mesh_bytes(rich, suffix))
    assert set(there) == set(CARRIED.get(suffix, ()))
    plain = TriangleMesh(mesh.positions, mesh.triangles)
    assert found(tmp_path, f"plain{suffix}", mesh_bytes(plain, suffix)) == []


def test_obj_has_materials_groups_and_more(tmp_path):
    (tmp_path / "a.mtl").write_text("newmtl red\nKd 1 0 0\nmap_Kd red.png\n")
    text = "mtllib a.mtl\no part\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nusemtl red\ns 1\n"
    text += "f 1/1/1 2/1/1 3/1/1\nl 1 2\n"
    assert found(tmp_path, "a.obj", text) == [
        "normals", "uvs", "materials", "groups", "smoothing groups", "lines", "textures",
    ]  # fmt: skip
    (tmp_path / "a.mtl").unlink()
    assert "textures" not in found(tmp_path, "a.obj", text)


def test_ply_has_other_properties_and_elements(tmp_path):
    text = (
        "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 3\nproperty float x\n"
        "property float y\nproperty float z\nproperty float quality\nproperty uchar alpha\n"
        "element face 1\nproperty list uchar int vertex_indices\nproperty uchar red\n"
        "property uchar green\nproperty uchar blue\nelement edge 1\nproperty int vertex1\n"
        "property int vertex2\nend_header\n0 0 0 1 9\n1 0 0 1 9\n0 1 0 1 9\n3 0 1 2 9 9 9\n0 1\n"
    )
    assert found(tmp_path, "a.ply", text) == [
        "vertex quality", "vertex alpha", "face colours", "edge", "textures",
    ]  # fmt: skip


def test_off_and_stl_have_colours(tmp_path):
    off = "COFF\n3 1 0\n0 0 0 9 9 9 9\n1 0 0 9 9 9 9\n0 1 0 9 9 9 9\n3 0 1 2 255 0 0\n"
    assert found(tmp_path, "a.off", off) == ["colours", "face colours"]
    stl = bytearray(mesh_bytes(TORUS, ".stl"))
    stl[84 + 48] = 7
    assert found(tmp_path, "a.stl", bytes(stl)) == ["face colours"]


def test_gltf_has_materials_and_several_meshes(tmp_path):
    image = np.zeros((2, 2, 3), np.uint8)
    from PIL import Image

    material = trimesh.visual.material.PBRMaterial(baseColorTexture=Image.fromarray(image))
    box = trimesh.creation.box()
    uvs = np.zeros((len(box.vertices), 2))
    box.visual = trimesh.visual.TextureVisuals(uv=uvs, material=material)
    scene = trimesh.Scene([box, trimesh.creation.icosphere(0)])
    data = scene.export(file_type="glb")
    there = found(tmp_path, "a.glb", data)
    assert {"uvs", "groups", "materials", "textures"} <= set(there)
    length = int.from_bytes(data[12:16], "little")
    assert json.loads(data[20 : 20 + length])["meshes"]


@pytest.mark.parametrize("suffix", read.SUFFIXES)
@settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_what_can_be_read_can_be_told(tmp_path, suffix, data):
    whole = mesh_bytes(triangles.plane(2).with_normals(), suffix)
    start = data.draw(st.integers(0, len(whole) - 1))
    end = data.draw(st.integers(start, min(len(whole), start + 8)))
    damaged = whole[:start] + data.draw(st.binary(max_size=8)) + whole[end:]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        path = tmp_path / f"damaged{suffix}"
        try:
            parse_mesh(damaged, path)
        except FileError:
            return
        assert all(isinstance(name, str) for name in extras(damaged, path))
