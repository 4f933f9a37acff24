"""Real shader stages as oracle: what the kernels give against what an OpenGL driver gives."""

import numpy as np
import pytest
from scipy.spatial import KDTree

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import displaced_icosphere, icosphere, terrain, torus
from lodbench.harness.plan.registry import systems
from lodbench.kernels.image import psnr
from lodbench.kernels.opencl.device import Unsupported
from lodbench.kernels.render import mesh_view, upload_surface
from lodbench.kernels.stages.camera import look_at
from lodbench.kernels.stages.raster import EMPTY_ID, Raster
from lodbench.kernels.stages.shading import Shading
from lodbench.kernels.system import Frame, Timeline, run
from tests.tolerances import (
    GL_COVERAGE,
    GL_DEPTH,
    GL_PSNR,
    GL_REPRESENTATIVE,
    GL_SHIFT,
    GL_VERTEX,
)

pytestmark = pytest.mark.gl
SIZE = (640, 512)


@pytest.fixture(autouse=True)
def needs_gl(gl):
    """Every test here talks to the driver."""


def prepare(name, device, mesh, **params):
    system = systems()[name]
    kind = type(next(iter(system.cases.values())))
    try:
        return system.prepare(device, mesh, kind(**params))
    except Unsupported as reason:
        pytest.skip(str(reason))


@pytest.mark.parametrize("segments", [1, 2, 7, 16])
@pytest.mark.parametrize("name", ["gl_pattern", "gl_static_vbo"])
def test_pattern_gives_the_points_and_normals_of_the_vertex_shader(device, name, segments):
    assert_same_vertices(device, "pattern", name, displaced_icosphere(4), segments)


def assert_same_vertices(device, ours, theirs, mesh, segments):
    shader = prepare(theirs, device, mesh, segments=segments, output="points").result()[0]
    kernel = refined(device, ours, mesh, segments).result()[0]
    np.testing.assert_array_equal(kernel.triangles, shader.triangles)
    scale = np.abs(kernel.positions).max()
    assert np.abs(kernel.positions - shader.positions).max() <= GL_VERTEX * scale
    assert np.abs(kernel.normals - shader.normals).max() <= GL_VERTEX


def refined(device, name, mesh, segments):
    kernel = prepare(name, device, mesh, segments=segments)
    run(device, kernel)
    return kernel


CURVED = {
    "bumps": lambda: displaced_icosphere(4),
    "torus": lambda: torus(12, 6),
    "terrain": lambda: terrain(6),
    "random normals": lambda: with_random_normals(icosphere(1)),
}


def with_random_normals(mesh):
    normals = np.random.default_rng(5).normal(size=(mesh.vertex_count, 3))
    return TriangleMesh(mesh.positions, mesh.triangles, normals)


@pytest.mark.parametrize("segments", [1, 2, 7, 16])
@pytest.mark.parametrize("name", list(CURVED)[:3])
def test_pn_triangles_give_the_points_and_normals_of_the_vertex_shader(device, name, segments):
    assert_same_vertices(device, "pn_triangles", "gl_pn_pattern", CURVED[name](), segments)


@pytest.mark.parametrize("name", CURVED)
@pytest.mark.parametrize("subject", ["gl_pn_pattern", "gl_pn_tessellation"])
def test_shaders_of_pn_triangles_agree_with_the_reference(device, subject, name):
    prepared = prepare(subject, device, CURVED[name](), segments=6, output="points")
    check = prepared.check()
    assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"


@pytest.mark.parametrize("segments", [1, 2, 8])
@pytest.mark.parametrize("name", list(CURVED)[:3])
def test_pn_triangles_meet_the_tessellation_stages_along_the_edges(device, name, segments):
    """Both cut an edge alike: what the tessellator gives there is among the pattern's vertices.

    Powers of two alone, since llvmpipe's tessellator counts in parts of 1/65536.
    """
    mesh = CURVED[name]()
    shader = prepare("gl_pn_tessellation", device, mesh, segments=segments, output="points")
    kept = shader.kept()
    kept = kept[kept["weights"].min(axis=1) == 0]
    ours = refined(device, "pn_triangles", mesh, segments).result()[0]
    scale = np.abs(ours.positions).max()
    both = np.hstack([ours.positions / scale, ours.normals])
    theirs = np.hstack([kept["point"] / scale, kept["normal"]])
    off, _ = KDTree(both).query(theirs, p=np.inf)
    assert len(kept) >= 3 * segments * mesh.triangle_count
    assert off.max() <= GL_VERTEX


def test_check_of_patches_finds_a_wrong_surface_and_one_that_is_not_there(device, monkeypatch):
    prepared = prepare("gl_pn_tessellation", device, icosphere(1), segments=4, output="points")
    assert prepared.check().passed
    kept = prepared.kept()
    monkeypatch.setattr(prepared, "kept", lambda: kept[: len(kept) // 2])
    assert not prepared.check().passed
    wrong = kept.copy()
    wrong["point"][7] += 1e-3
    monkeypatch.setattr(prepared, "kept", lambda: wrong)
    assert not prepared.check().passed


@pytest.mark.parametrize("segments", [1, 2, 5, 8])
def test_pattern_covers_the_triangles_of_the_tessellation_stages(device, segments):
    mesh = icosphere(1)
    prepared = prepare("gl_tessellation", device, mesh, segments=segments, output="points")
    assert prepared.check().passed
    shader = prepared.result()[0]
    assert shader.triangle_count == prepared.counters()["triangles"]
    kernel = refined(device, "pattern", mesh, segments)
    areas = [
        np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
        for a, b, c in (
            m.positions[m.triangles].swapaxes(0, 1) for m in (shader, kernel.result()[0])
        )
    ]
    np.testing.assert_allclose(*areas, rtol=1e-5)


def pixels(device, surfaces, shader, view):
    """Ours and the driver's: image, what is covered, depth."""
    raster = Raster(device, surfaces, view.width, view.height, Shading())
    raster(surfaces, Frame(view), Timeline())
    depth, ids = raster.keys()
    shader.enqueue(Frame(view), Timeline())
    depths = shader.canvas.depths()
    return (raster.image(), ids != EMPTY_ID, depth), (shader.image(), depths < 1, depths)


def away_from_outlines(covered, depth):
    """Pixels whose eight neighbours are covered too and lie near the plane through them."""
    inside = np.zeros_like(covered)
    inside[1:-1, 1:-1] = True
    bend = np.zeros(depth.shape)
    for dy in (-1, 0, 1):
        for dx in (-1, 0, 1):
            inside &= np.roll(covered, (dy, dx), (0, 1))
            pair = np.roll(depth, (dy, dx), (0, 1)) + np.roll(depth, (-dy, -dx), (0, 1))
            bend = np.maximum(bend, np.abs(pair - 2 * depth))
    return inside & (bend < 2e-3 * np.ptp(depth[covered]))


MESHES = {
    "sphere": icosphere(4),
    "bumps": displaced_icosphere(30),
    "torus": torus(120, 60),
    "terrain": terrain(100),
}


def assert_same_picture(device, mesh, view):
    shader = prepare("gl_static_vbo", device, mesh, width=view.width, height=view.height)
    assert_drawn_alike(device, [upload_surface(device, mesh)], shader, view)


def assert_drawn_alike(device, surfaces, shader, view):
    ours, theirs = pixels(device, surfaces, shader, view)
    assert ours[1].any()
    assert (ours[1] != theirs[1]).mean() < GL_COVERAGE
    where = away_from_outlines(*ours[1:]) & away_from_outlines(*theirs[1:])
    assert where.mean() > 0.05
    assert psnr(ours[0], theirs[0], where) >= GL_PSNR
    steps = [np.abs(np.roll(ours[2], 1, axis) - ours[2]) for axis in (0, 1)]
    steps += [np.roll(step, -1, axis) for axis, step in enumerate(steps)]
    off = np.abs(ours[2] - theirs[2]) - GL_SHIFT * np.max(steps, axis=0)
    assert off[where].max() <= GL_DEPTH


@pytest.mark.parametrize("name", MESHES)
def test_image_is_the_drivers(device, name):
    assert_same_picture(device, MESHES[name], mesh_view(MESHES[name], size=SIZE))


@pytest.mark.parametrize("name", CURVED)
def test_image_of_pn_triangles_is_the_drivers(device, name):
    mesh, segments = CURVED[name](), 8
    view = mesh_view(mesh, size=SIZE)
    size = {"width": SIZE[0], "height": SIZE[1]}
    shader = prepare("gl_pn_pattern", device, mesh, segments=segments, **size)
    surfaces = refined(device, "pn_triangles", mesh, segments).output
    assert_drawn_alike(device, surfaces, shader, view)


def test_image_from_within_and_across_the_near_plane_is_the_drivers(device):
    # the eye inside the torus' tube: triangles behind it, across the near plane and far outside the image
    view = look_at((1.0, 0.05, 0), (1.0, 0.0, -1.0), size=SIZE, near=0.05, far=10, fov_y=75)
    assert_same_picture(device, MESHES["torus"], view)


@pytest.mark.parametrize("name", ["bunny_69k", "dragon_100k"])
def test_image_of_a_scan_is_the_drivers(device, data_folder, name):
    from lodbench.datasets_gen.read import read_mesh

    mesh = read_mesh(data_folder / "meshes" / f"{name}.ply")
    assert_same_picture(device, mesh, mesh_view(mesh, size=SIZE))


def assert_same_clusters(device, mesh, cells, placement):
    shader = prepare("gl_quadric_clustering", device, mesh, cells=cells, placement=placement)
    run(device, shader)
    kernel = prepare("quadric_clustering", device, mesh, cells=cells, placement=placement)
    run(device, kernel)
    assert shader.check().passed
    theirs, ours = shader.result()[0], kernel.result()[0]
    np.testing.assert_array_equal(theirs.triangles, ours.triangles)
    cell = (mesh.box[1] - mesh.box[0]).max() / cells
    off = np.linalg.norm(theirs.positions - ours.positions, axis=1) / cell
    assert np.median(off) <= GL_REPRESENTATIVE


@pytest.mark.parametrize("placement", ["robust", "paper", "average"])
@pytest.mark.parametrize("cells", [2, 7, 40])
def test_clusters_are_those_of_the_published_passes(device, cells, placement):
    assert_same_clusters(device, displaced_icosphere(30), cells, placement)


def test_clusters_of_the_bunny_are_those_of_the_published_passes(device, data_folder):
    from lodbench.datasets_gen.read import read_mesh

    mesh = read_mesh(data_folder / "meshes" / "bunny_69k.ply")
    assert_same_clusters(device, mesh, 90, "robust")
