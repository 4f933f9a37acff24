import pytest

from lodbench.datasets_gen import catalogue, nurbs
from lodbench.datasets_gen.finest import finest
from lodbench.datasets_gen.nurbs_surface import NurbsModel
from lodbench.harness.baselines.gl.gl_nurbs import SYSTEM, Params
from lodbench.kernels.image import psnr
from lodbench.kernels.nurbs.uniform_nurbs import Params as Uniform
from lodbench.kernels.nurbs.uniform_nurbs import UniformNurbs
from lodbench.kernels.render import mesh_view
from lodbench.kernels.stages.raster import Raster
from lodbench.kernels.stages.shading import Shading
from lodbench.kernels.system import Frame, Timeline, Unsupported, run
from tests.kernels.nurbs.surfaces import random_surface

pytestmark = pytest.mark.gl
MODELS = {
    "ball": nurbs.ball(),
    "all degrees": nurbs.mixed_degrees(),
    "one degree, uneven": NurbsModel((random_surface((2, 5), (3, 4), 2),)),
    "flat": NurbsModel((random_surface((1, 1), (1, 1), 0, rational=False),)),
}


@pytest.fixture(autouse=True)
def needs_gl(gl):
    """Every test here talks to the driver."""


def prepare(device, model, *values, **params):
    try:
        return SYSTEM.prepare(device, model, Params(*values, **params))
    except Unsupported as reason:
        pytest.skip(str(reason))


@pytest.mark.parametrize("level", [0, 3])
@pytest.mark.parametrize("name", MODELS)
def test_points_and_normals_of_the_shader_are_those_of_the_surfaces(device, name, level):
    shader = prepare(device, MODELS[name], level, "points")
    run(device, shader)
    assert shader.check().passed, shader.check()
    counts, (mesh,) = shader.counters(), shader.result()
    assert counts["quads"] == MODELS[name].span_count
    assert (mesh.triangle_count, mesh.vertex_count) == (counts["triangles"], counts["vertices"])


def test_shader_of_a_real_model(device, data_folder):
    shader = prepare(device, catalogue.load("hammer_nd").surface.recentred()[0], 1, "points")
    run(device, shader)
    assert shader.check().passed, shader.check()


def test_picture_of_the_shader_is_ours(device):
    model = nurbs.torus()
    view = mesh_view(finest(model), size=(320, 256))
    shader = prepare(device, model, 4, width=320, height=256)
    shader.enqueue(Frame(view), Timeline())
    ours = UniformNurbs(device, model, Uniform(4, "span"))
    run(device, ours)
    raster = Raster(device, ours.output, 320, 256, Shading())
    raster(ours.output, Frame(view), Timeline())
    assert psnr(raster.image(), shader.image()) > 34


def test_no_surfaces_are_an_empty_picture(device):
    shader = prepare(device, NurbsModel(()), 2)
    run(device, shader)
    assert shader.counters()["triangles"] == 0 and shader.check().passed
