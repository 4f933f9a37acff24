import json

import numpy as np
import pytest
import trimesh

from lodbench.datasets_gen import gltf
from lodbench.datasets_gen.read import FileError, mesh_bytes, read_mesh
from lodbench.datasets_gen.surfaces import TriangleMesh

PLACE = np.diag([2.0, 3.0, -1.0, 1.0])
PLACE[:3, 3] = 5, 0, 0


def box(seed, uvs=True):
    """A box with hard edges, normals and a material of its own."""
    loose = trimesh.creation.box()
    loose.unmerge_vertices()
    result = trimesh.Trimesh(
        loose.vertices,
        loose.faces,
        vertex_normals=np.repeat(loose.face_normals, 3, 0),
        process=False,
    )
    if uvs:
        result.visual = trimesh.visual.TextureVisuals(
            uv=np.random.default_rng(seed).random((36, 2)),
            material=trimesh.visual.material.PBRMaterial(baseColorFactor=[seed, 0, 0, 255]),
        )
    return result


def scene_of(tmp_path, *shapes):
    scene = trimesh.Scene()
    for shape, place in shapes:
        scene.add_geometry(shape, transform=place)
    (tmp_path / "scene.glb").write_bytes(scene.export(file_type="glb", include_normals=True))
    return read_mesh(tmp_path / "scene.glb")


def test_uvs_and_normals_of_several_materials_are_joined_in_place(tmp_path):
    one, two = box(1), box(2)
    mesh = scene_of(tmp_path, (one, np.eye(4)), (two, PLACE))
    assert mesh.vertex_count == 72
    moved = mesh.positions[:, 0] > 2
    for shape, rows in ((one, ~moved), (two, moved)):
        assert np.abs(mesh.uvs[rows] - shape.visual.uv).max() < 1e-6
    faces = TriangleMesh(mesh.positions, mesh.triangles).with_normals().normals
    assert np.abs(mesh.normals - faces).max() < 1e-6, "stretched and mirrored"


def test_what_one_mesh_lacks_is_left_out(tmp_path):
    mesh = scene_of(tmp_path, (box(1), np.eye(4)), (box(2, uvs=False), PLACE))
    assert mesh.vertex_count == 72 and mesh.uvs is None and mesh.normals is not None


def test_what_is_written_has_its_real_names_and_v_downwards(tmp_path):
    uvs = np.array([(0, 0), (1, 0), (0, 0.25)])
    mesh = TriangleMesh(np.eye(3), [(0, 1, 2)], uvs=uvs)
    document = json.loads(mesh_bytes(mesh, ".gltf"))
    (part,) = document["meshes"][0]["primitives"]
    assert set(part["attributes"]) == {"POSITION", "TEXCOORD_0"}
    (tmp_path / "a.glb").write_bytes(mesh_bytes(mesh, ".glb"))
    with (tmp_path / "a.glb").open("rb") as stream:
        found = trimesh.exchange.gltf.load_glb(gltf_bytes(stream.read()))
    (shape,) = found["geometry"].values()
    assert np.array_equal(shape["vertex_attributes"][gltf.UV], gltf.turned_over(uvs))
    assert np.array_equal(read_mesh(tmp_path / "a.glb").uvs, uvs)


def gltf_bytes(data):
    import io

    return io.BytesIO(gltf.marked(data))


def test_whole_numbers_are_shares_of_the_largest():
    shape = trimesh.Trimesh(np.eye(3), [(0, 1, 2)], process=False)
    shape.vertex_attributes[gltf.UV] = np.array([(0, 255), (255, 0), (51, 51)], np.uint8)
    scene = trimesh.Scene(shape)
    found = gltf.attributes(scene, scene.dump())["uvs"]
    assert np.allclose(found, [(0, 0), (1, 1), (0.2, 0.8)])


def test_what_is_not_finite_is_left_out(tmp_path):
    mesh = TriangleMesh(np.eye(3), [(0, 1, 2)], normals=np.eye(3))
    data = mesh_bytes(mesh, ".glb").replace(np.eye(3, dtype="<f4").tobytes(), b"\xff" * 36)
    (tmp_path / "nan.glb").write_bytes(data)
    with pytest.raises(FileError, match="points: expected finite"):
        read_mesh(tmp_path / "nan.glb")  # the points are those bytes too
    points = np.eye(3) * 2
    data = mesh_bytes(TriangleMesh(points, [(0, 1, 2)], normals=np.eye(3)), ".glb")
    (tmp_path / "nan.glb").write_bytes(data.replace(np.eye(3, dtype="<f4").tobytes(), b"\xff" * 36))
    found = read_mesh(tmp_path / "nan.glb")
    assert found.normals is None and np.array_equal(found.positions, points)


@pytest.mark.parametrize("data", [b"", b"glTF", b"{", b"{}", b"[1]", b'{"meshes": [{}]}', b"\xff"])
def test_what_is_broken_is_left_to_the_reader(data):
    assert gltf.marked(data) == data
    whole = mesh_bytes(TriangleMesh(np.eye(3), [(0, 1, 2)]), ".glb")
    assert gltf.marked(whole[:40]) == whole[:40]
