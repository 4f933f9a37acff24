import numpy as np
import pytest

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.baselines.gl.driver import driver_name
from lodbench.harness.baselines.gl.patches import MOST_VERTICES, ring_triangles, ring_vertices
from lodbench.harness.baselines.gl.refined import Params
from lodbench.harness.plan.registry import systems
from lodbench.kernels.refine import adaptive_patterns
from lodbench.kernels.refine.adaptive_patterns.reference import edge_depths
from lodbench.kernels.render import mesh_view
from lodbench.kernels.system import Frame, Timeline, Unsupported, run

pytestmark = pytest.mark.gl
FLAT = ("gl_static_vbo", "gl_pattern", "gl_tessellation")
CURVED = ("gl_pn_pattern", "gl_pn_tessellation")
NAMES = FLAT + CURVED


@pytest.fixture(autouse=True)
def needs_gl(gl):
    """Every test here talks to the driver."""


def prepare(name, device, mesh, params):
    try:
        return systems()[name].prepare(device, mesh, params)
    except Unsupported as reason:
        pytest.skip(str(reason))


def test_driver_has_a_name():
    assert driver_name()


@pytest.mark.parametrize(
    ("name", "like"),
    [*((name, "gl_static_vbo") for name in FLAT), ("gl_pn_tessellation", "gl_pn_pattern")],
)
def test_frame_draws_the_same_picture_whatever_the_stages(device, name, like):
    mesh, params = icosphere(3), Params(16, width=160, height=128)
    pictures = []
    for subject in (name, like):
        prepared = prepare(subject, device, mesh, params)
        run(device, prepared)
        pictures.append(prepared.image())
    assert pictures[0].shape == (128, 160, 3)
    assert (np.abs(pictures[0].astype(int) - pictures[1]).max(-1) > 3).mean() < 0.01


@pytest.mark.parametrize("name", NAMES)
def test_frame_follows_the_view_and_refuses_another_size(device, name):
    mesh = icosphere(1)
    prepared = prepare(name, device, mesh, Params(2, width=96, height=64))
    run(device, prepared)
    first = prepared.image()
    prepared.enqueue(Frame(mesh_view(mesh, (200, -30), (96, 64))), Timeline())
    assert (prepared.image() != first).any()
    with pytest.raises(ValueError, match="view: expected 96 x 64 pixels, got 1280 x 1024"):
        prepared.enqueue(Frame(mesh_view(mesh)), Timeline())


@pytest.mark.parametrize("name", NAMES)
def test_empty_mesh_draws_the_background(device, name):
    prepared = prepare(
        name,
        device,
        TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int)),
        Params(2, width=40, height=30),
    )
    run(device, prepared)
    assert prepared.check().passed
    image = prepared.image()
    np.testing.assert_array_equal(image, image[:, :1].repeat(40, 1))


@pytest.mark.parametrize(
    ("segments", "triangles", "vertices"),
    [(1, 1, 3), (2, 6, 7), (3, 13, 12), (4, 24, 19), (16, 384, 217)],
)
def test_rings_of_the_tessellator_are_counted(device, segments, triangles, vertices):
    assert (ring_triangles(segments), ring_vertices(segments)) == (triangles, vertices)
    params = Params(segments, "points")
    (made,) = prepare("gl_tessellation", device, icosphere(0), params).result()
    assert made.triangle_count == 20 * triangles
    # an edge's two triangles may differ in the last place of its points
    assert len(np.unique(made.positions[: 3 * triangles], axis=0)) == vertices


@pytest.mark.parametrize("name", ["gl_tessellation", "gl_pn_tessellation"])
def test_every_patch_comes_once_when_they_take_many_draws(device, name):
    """A software driver loses patches of a draw that gives more vertices than 16 bits can number."""
    mesh, segments = icosphere(3), 16
    assert mesh.triangle_count * ring_vertices(segments) > 4 * MOST_VERTICES
    prepared = prepare(name, device, mesh, Params(segments, "points"))
    kept = prepared.kept()["corners"][:: 3 * ring_triangles(segments)]
    assert len(kept) == mesh.triangle_count
    assert len(np.unique(kept, axis=0)) == mesh.triangle_count
    assert prepared.check().passed


@pytest.mark.parametrize("name", ["gl_tessellation", "gl_pn_tessellation"])
def test_tessellation_past_the_drivers_limit_is_unsupported(device, name):
    with pytest.raises(Unsupported, match="segments"):
        systems()[name].prepare(device, icosphere(0), Params(100_000))


def test_params_are_checked():
    with pytest.raises(ValueError, match="segments: expected at least 1, got 0"):
        Params(0)
    with pytest.raises(ValueError, match="output: expected one of image, points, got 'film'"):
        Params(1, "film")


@pytest.mark.parametrize("pixels", [2.0, 8.0, 1e6])
def test_adaptive_tessellation_asks_for_what_the_screen_does(device, pixels):
    mesh, system = icosphere(2), systems()["gl_adaptive_tessellation"]
    kind = type(next(iter(system.cases.values())))
    params = kind(16, width=160, height=128, pixels=pixels)
    prepared = system.prepare(device, mesh, params)
    check = prepared.check()
    assert check.passed, check
    ours = adaptive_patterns.AdaptivePatterns(
        device, mesh, adaptive_patterns.Params(16, by="screen", pixels=pixels)
    )
    run(device, ours, Frame(mesh_view(mesh, size=(160, 128))))
    depths, _ = edge_depths(prepared.mesh.triangles, ours.tags(), 4)
    rows = prepared.kept()
    for triangle in (0, 17, 200):
        own = rows[(rows["corners"] == prepared.mesh.triangles[triangle]).all(axis=1)]
        for edge, depth in enumerate(depths[triangle]):
            on = own["weights"][own["weights"][:, edge] == 0]
            assert len(np.unique(on, axis=0)) == (1 << depth) + 1
    counts = prepared.counters()
    assert counts["triangles"] == len(rows) // 3 >= mesh.triangle_count
    assert pixels < 1e6 or counts["triangles"] == mesh.triangle_count
