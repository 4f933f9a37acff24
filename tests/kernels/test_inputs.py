import importlib
from dataclasses import dataclass

import numpy as np
import pytest
import trimesh

from lodbench.datasets_gen.read import write_mesh
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, torus
from lodbench.kernels import refine, refine_mesh, render, simplify, simplify_mesh
from lodbench.kernels.image import psnr
from lodbench.kernels.inputs import as_mesh
from lodbench.kernels.render import mesh_view
from lodbench.kernels.stages.camera import look_at
from tests.tolerances import EPSILON32

MAP = np.array((4e5, 5e6, 100.0))
TORUS = torus(24, 12)
NEAR = TORUS.positions.astype(np.float64)
SIZE = (120, 90)
CALLS = {
    "simplify": lambda points, faces, device: simplify(points, faces, 0.5, device=device),
    "refine": lambda points, faces, device: refine(points, faces, 3, device=device),
}


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_dtype_that_came_in_comes_out(device, call):
    single, double = (
        call(NEAR.astype(dtype), TORUS.triangles, device) for dtype in (np.float32, np.float64)
    )
    assert single[0].dtype == np.float32 and double[0].dtype == np.float64
    assert np.array_equal(single[0], double[0]) and np.array_equal(single[1], double[1])


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_far_from_the_origin_the_result_is_the_same(device, call):
    near, far = (call(NEAR + offset, TORUS.triangles, device) for offset in (0, MAP))
    assert far[0].dtype == np.float64
    assert np.array_equal(near[1], far[1])
    assert np.abs(far[0] - MAP - near[0]).max() <= 16 * EPSILON32 * TORUS.diagonal


def test_far_from_the_origin_the_picture_is_the_same(device):
    near = render(NEAR, TORUS.triangles, size=SIZE, device=device)
    assert psnr(render(NEAR + MAP, TORUS.triangles, size=SIZE, device=device), near) > 60
    eye, target = np.array((1.0, 2.0, 4.0)), np.array((0.1, 0.0, 0.0))
    views = [look_at(eye + offset, target + offset, size=SIZE) for offset in (0, MAP)]
    one, other = (
        render(NEAR + offset, TORUS.triangles, camera=view, device=device)
        for view, offset in zip(views, (0, MAP), strict=True)
    )
    assert psnr(one, other) > 50
    far = TriangleMesh(NEAR + MAP, TORUS.triangles)
    seen = render(far, camera=mesh_view(far, size=SIZE), device=device)
    assert psnr(seen, near) > 50, "a view of the mesh is a view of the world"


def test_results_keep_the_origin_with_every_level(device):
    mesh = TriangleMesh(NEAR + MAP, TORUS.triangles)
    for result in (
        simplify_mesh(device, mesh, target_reduction=0.5),
        refine_mesh(device, mesh, segments=2),
    ):
        for level in (result.mesh, *result.levels):
            assert np.abs(level.points - MAP).max() < 10


def test_geometry_image_of_far_points_is_simplified_in_place(device):
    from lodbench.kernels.geometry_image.parameterisation import full_mesh, geometry_image

    ball = icosphere(1)
    image = geometry_image(
        TriangleMesh(ball.positions + MAP, ball.triangles), 3, device=device, cache=False
    )
    assert np.abs(full_mesh(image).points - MAP).max() < 1.1
    points, _ = simplify(image, target_count=50, method="quadtree_lod", device=device)
    assert points.dtype == np.float64 and np.abs(points - MAP).max() < 1.2


def test_quality_compares_meshes_of_two_origins():
    pytest.importorskip("igl")
    from lodbench.harness.measure.quality import measure

    far = TriangleMesh(NEAR + MAP, TORUS.triangles)
    other = TriangleMesh(NEAR.astype(np.float32), TORUS.triangles, origin=MAP)
    moved = other.with_origin(MAP + np.array((0.01 * TORUS.diagonal, 0, 0)))
    assert measure(far, other, samples=100)["max_error"] < 1e-6
    assert 0.001 < measure(far, moved, samples=100)["max_error"] <= 0.0101


def test_scenes_and_paths_are_taken(tmp_path, device):
    box = trimesh.creation.box()
    scene = trimesh.Scene()
    scene.add_geometry(box)
    scene.add_geometry(box, transform=trimesh.transformations.translation_matrix((5, 0, 0)))
    mesh = as_mesh(scene)
    assert mesh.triangle_count == 24 and mesh.box[1][0] == 5.5
    assert refine(scene, segments=2, device=device)[0].dtype == np.float64
    assert as_mesh(trimesh.Scene()).triangle_count == 0
    write_mesh(tmp_path / "torus.ply", TORUS)
    for path in (tmp_path / "torus.ply", str(tmp_path / "torus.ply")):
        points, faces = simplify(path, cells=300, device=device)
        assert points.dtype == np.float32 and len(faces) == TORUS.triangle_count
    with pytest.raises(ValueError, match=r"none\.ply: no such file"):
        simplify(tmp_path / "none.ply", cells=3)


def test_colours_of_vertices_come_along():
    colours = np.array([(255, 0, 0, 255), (0, 255, 0, 255), (0, 0, 51, 255)], np.uint8)
    given = trimesh.Trimesh(np.eye(3), [(0, 1, 2)], vertex_colors=colours, process=False)
    assert np.allclose(as_mesh(given).colours, [(1, 0, 0), (0, 1, 0), (0, 0, 0.2)])
    assert as_mesh(trimesh.creation.box()).colours is None


def test_normals_and_uvs_come_along_where_they_are():
    normals, uvs = np.eye(3)[[1, 2, 0]], np.arange(6).reshape(3, 2) / 8
    given = trimesh.Trimesh(np.eye(3), [(0, 1, 2)], vertex_normals=normals, process=False)
    given.visual = trimesh.visual.TextureVisuals(uv=uvs)
    given.visual.vertex_attributes["color"] = np.array([(255, 0, 51, 255)] * 3, np.uint8)
    mesh = as_mesh(given)
    assert np.array_equal(mesh.normals, normals) and np.array_equal(mesh.uvs, uvs)
    assert np.allclose(mesh.colours, (1, 0, 0.2))
    bare = as_mesh(trimesh.Trimesh(np.eye(3), [(0, 1, 2)], process=False))
    assert bare.normals is None and bare.uvs is None, "none are made"
    given.visual.uv = np.full((3, 2), np.nan)
    assert as_mesh(given).uvs is None


def test_attributes_of_pyvista_come_along():
    class PointData(dict):
        active_normals = np.eye(3)

    mesh = PolyData(np.eye(3))
    mesh.point_data = PointData(RGBA=np.array([(0, 255, 51, 9)] * 3, np.uint8))
    mesh.active_texture_coordinates = np.ones((3, 2))
    found = as_mesh(mesh)
    assert np.array_equal(found.normals, np.eye(3)) and (found.uvs == 1).all()
    assert np.allclose(found.colours, (0, 1, 0.2))
    mesh.point_data = PointData(RGB=np.full((3, 3), 0.25))
    assert (as_mesh(mesh).colours == 0.25).all()


@dataclass
class PolyData:
    """What pyvista's has, without pyvista."""

    points: np.ndarray
    corners: int = 3

    @property
    def regular_faces(self):
        if not self.corners:
            raise ValueError("Faces are not regular")
        return np.zeros((2 if self.corners > 2 else 0, self.corners), np.int64)


def test_polygons_of_pyvista_are_to_be_triangulated():
    assert as_mesh(PolyData(np.eye(3))).triangle_count == 2
    assert as_mesh(PolyData(np.eye(3), 1)).triangle_count == 0, "lines or points alone"
    with pytest.raises(ValueError, match=r"polygons of 4 corners: call \.triangulate\(\) on it"):
        as_mesh(PolyData(np.eye(3), 4))
    with pytest.raises(ValueError, match=r"polygons of several sizes: call \.triangulate\(\)"):
        as_mesh(PolyData(np.eye(3), 0))


def test_volumes_of_pyvista_are_to_be_cut_open():
    class UnstructuredGrid:
        points = np.eye(3)

        def extract_surface(self):
            raise AssertionError

    with pytest.raises(TypeError, match=r"UnstructuredGrid: call \.extract_surface\(\)"):
        as_mesh(UnstructuredGrid())


def test_calls_stay_calls_whatever_is_imported():
    import lodbench.kernels

    importlib.import_module("lodbench.kernels.refine.pattern")
    importlib.import_module("lodbench.kernels.render")
    for name in lodbench.kernels.__all__:
        assert callable(getattr(lodbench.kernels, name)), name
