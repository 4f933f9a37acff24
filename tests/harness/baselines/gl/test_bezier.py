"""Bezier patches in real shader stages: rival of the kernels, and oracle."""

import numpy as np
import pytest

from lodbench.datasets_gen import patches
from lodbench.datasets_gen.finest import finest
from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.harness.baselines.gl.bezier import Params
from lodbench.harness.baselines.gl.patches import MOST_VERTICES
from lodbench.harness.plan.registry import systems
from lodbench.kernels.bezier import vst
from lodbench.kernels.image import psnr
from lodbench.kernels.render import mesh_view
from lodbench.kernels.stages.raster import Raster
from lodbench.kernels.stages.shading import Shading
from lodbench.kernels.system import Frame, Timeline, Unsupported, run
from tests.kernels.bezier.patches import NASTY
from tests.tolerances import GL_VERTEX

pytestmark = pytest.mark.gl
NAMES = ("gl_vst", "gl_gst", "gl_bezier_tessellation")


@pytest.fixture(autouse=True)
def needs_gl(gl):
    """Every test here talks to the driver."""


def prepare(name, device, surface, *values, **params):
    try:
        return systems()[name].prepare(device, surface, Params(*values, **params))
    except Unsupported as reason:
        pytest.skip(str(reason))


@pytest.mark.parametrize("level", [0, 1, 3, 5])
@pytest.mark.parametrize("name", NAMES)
def test_points_and_normals_of_shaders_are_those_of_vst(device, name, level):
    surface = patches.cup()
    shader = prepare(name, device, surface, level, "points")
    run(device, shader)
    check = shader.check()
    assert check.passed, check
    rows = shader.kept()
    ours = vst.Vst(device, surface, vst.Params(level))
    run(device, ours)
    (mesh,) = ours.result()
    side = (1 << level) + 1
    row, column = np.rint(rows["uv"] * (1 << level)).astype(int).T
    place = (rows["patch"] * side + row) * side + column
    assert np.array_equal(np.unique(place), np.arange(len(mesh.positions)))
    assert np.abs(rows["point"] - mesh.positions[place]).max() <= GL_VERTEX * np.ptp(mesh.positions)
    turned = np.linalg.norm(rows["normal"] - mesh.normals[place], axis=1)
    assert np.quantile(turned, 0.99) <= np.deg2rad(0.1)  # ours are shared along smooth borders
    counts = shader.counters()
    assert counts["triangles"] == 26 * 2 * 4**level and counts["vertices"] == 26 * side**2
    if name != "gl_vst":
        assert len(rows) == 3 * counts["triangles"]
    assert shader.result()[0].triangle_count == counts["triangles"]


@pytest.mark.parametrize("name", NAMES)
def test_picture_of_shaders_is_ours(device, name):
    surface = patches.pot(4)
    view = mesh_view(finest(surface), size=(320, 256))
    shader = prepare(name, device, surface, 4, width=320, height=256)
    shader.enqueue(Frame(view), Timeline())
    ours = vst.Vst(device, surface, vst.Params(4))
    run(device, ours)
    raster = Raster(device, ours.output, 320, 256, Shading())
    raster(ours.output, Frame(view), Timeline())
    assert psnr(raster.image(), shader.image()) > 34  # zones and rings cut cells the other way


@pytest.mark.parametrize("what", NASTY)
@pytest.mark.parametrize("name", NAMES)
def test_shaders_bear_nasty_patches(device, name, what):
    surface = BezierPatches(NASTY[what])
    shader = prepare(name, device, surface, 2, "points")
    run(device, shader)
    assert np.isfinite(shader.kept()["normal"]).all()
    assert shader.check().passed, shader.check()


@pytest.mark.parametrize("name", NAMES)
def test_no_patches_draw_the_background(device, name):
    empty = BezierPatches(np.zeros((0, 4, 4, 3)))
    shader = prepare(name, device, empty, 2, width=40, height=30)
    run(device, shader)
    assert shader.check().passed
    image = shader.image()
    assert np.array_equal(image, image[:, :1].repeat(40, 1))


def test_every_patch_comes_once_when_they_take_many_draws(device):
    surface = patches.copies(patches.pot(4), 3)
    assert len(surface.points) * 65**2 > 4 * MOST_VERTICES
    shader = prepare("gl_bezier_tessellation", device, surface, 6, "points")
    count = np.bincount(shader.kept()["patch"])
    assert np.array_equal(count, np.full(48, 6 * 64**2))
    assert shader.check().passed


def test_zones_of_a_geometry_shader_keep_its_limit(device):
    for level in range(7):
        counts = prepare("gl_gst", device, patches.cup(), level).counters()
        assert counts["zone_values"] <= 1024
    assert counts["zones"] == 26 * 128


def test_check_of_patches_finds_a_wrong_point_and_one_that_is_not_there(device, monkeypatch):
    shader = prepare("gl_gst", device, patches.cup(), 2, "points")
    kept = shader.kept()
    monkeypatch.setattr(shader, "kept", lambda: kept[kept["patch"] != 7])
    assert not shader.check().passed
    wrong = kept.copy()
    wrong["point"][7] += 1e-4
    monkeypatch.setattr(shader, "kept", lambda: wrong)
    assert not shader.check().passed


def test_tessellation_past_the_drivers_limit_is_unsupported(device):
    with pytest.raises(Unsupported, match="segments"):
        systems()["gl_bezier_tessellation"].prepare(device, patches.cup(), Params(10))
