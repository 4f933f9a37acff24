"""What a mesh is given back as, and that it is read again as what it was."""

import numpy as np
import pytest
import trimesh

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import torus
from lodbench.kernels import simplify_mesh
from lodbench.kernels.inputs import as_mesh
from lodbench.kernels.outputs import as_given

MESH = torus(20, 12)
ATTRIBUTES = {
    "normals": MESH.normals,
    "uvs": MESH.positions[:, :2] / 4 + 0.5,
    "colours": np.round((MESH.positions / 8 + 0.5) * 255) / 255,
}


def with_all():
    return TriangleMesh(MESH.positions, MESH.triangles, **ATTRIBUTES)


def same(mesh, other):
    assert np.array_equal(mesh.triangles, other.triangles)
    assert np.allclose(mesh.points, other.points)
    for name in ATTRIBUTES:
        ours, theirs = getattr(mesh, name), getattr(other, name)
        assert (ours is None) == (theirs is None), name
        assert ours is None or np.allclose(ours, theirs, atol=1e-6), name


def test_arrays_and_meshes_come_back_as_they_came(device):
    result = simplify_mesh(device, MESH, cells=6)
    assert result.to(MESH) is result.mesh
    points, faces = result.to((MESH.positions, MESH.triangles))
    assert points is result.mesh.points and faces is result.mesh.triangles


@pytest.mark.parametrize("names", [(), ("normals",), ("colours",), ("uvs",), tuple(ATTRIBUTES)])
def test_trimesh_comes_back_as_trimesh_with_its_attributes(names):
    mesh = TriangleMesh(MESH.positions, MESH.triangles, **{k: ATTRIBUTES[k] for k in names})
    given = trimesh.creation.box()
    if "uvs" in names:
        given.visual = trimesh.visual.TextureVisuals(uv=np.zeros((8, 2)))
    made = as_given(mesh, given)
    assert type(made) is trimesh.Trimesh
    same(as_mesh(made), mesh)


def test_a_material_stays_with_texture_coordinates(device):
    given = trimesh.Trimesh(MESH.positions, MESH.triangles, process=False)
    material = trimesh.visual.material.SimpleMaterial(diffuse=(9, 8, 7, 255))
    given.visual = trimesh.visual.TextureVisuals(uv=ATTRIBUTES["uvs"], material=material)
    made = simplify_mesh(device, given, cells=6).to(given)
    assert made.visual.material is material
    assert len(made.visual.uv) == len(made.vertices)


def test_pyvista_comes_back_as_pyvista_with_its_attributes(device):
    pyvista = pytest.importorskip("pyvista")
    made = as_given(with_all(), pyvista.PolyData())
    assert isinstance(made, pyvista.PolyData)
    same(as_mesh(made), with_all())
    sphere = pyvista.Sphere()
    small = simplify_mesh(device, sphere, target_reduction=0.5).to(sphere)
    assert 0 < small.n_cells <= sphere.n_cells / 2


def test_what_cannot_be_made_is_refused(device):
    result = simplify_mesh(device, MESH, cells=6)
    with pytest.raises(TypeError, match=r"given: expected .* got Scene"):
        result.to(trimesh.Scene())
    with pytest.raises(TypeError, match=r"got str"):
        result.to("x.ply")
