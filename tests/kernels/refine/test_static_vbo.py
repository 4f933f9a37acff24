import numpy as np
import pytest

from lodbench.datasets_gen.shapes import spool
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, plane
from lodbench.kernels.opencl.device import Device, Unsupported
from lodbench.kernels.refine import pattern, pn_triangles, st_triangles
from lodbench.kernels.refine.static_vbo import Params
from lodbench.kernels.refine.static_vbo.host import StaticVbo
from lodbench.kernels.system import Frame, run


def as_bytes(mesh):
    return mesh.positions.tobytes(), mesh.normals.tobytes(), mesh.triangles.tobytes()


@pytest.mark.parametrize("amplitude", [0.0, 0.02])
@pytest.mark.parametrize("segments", [1, 2, 7, 16, 33])
@pytest.mark.parametrize("make", [lambda: icosphere(1), lambda: plane(9, 7)])
def test_static_vbo_gives_the_patterns_bits(device, make, segments, amplitude):
    drawn = pattern.Pattern(device, make(), pattern.Params(segments, amplitude=amplitude))
    stored = StaticVbo(device, make(), Params(segments, amplitude=amplitude))
    for prepared in (drawn, stored):
        run(device, prepared)
    assert as_bytes(stored.result()[0]) == as_bytes(drawn.result()[0])
    assert as_bytes(stored.welded()) == as_bytes(drawn.welded())
    assert stored.check().passed


TURBULENCE = {"displacement": "turbulence", "amplitude": 0.02, "waves": 5.0, "octaves": 2}
SURFACES = {
    "flat": (pattern.Pattern, pattern.Params, {}),
    "pn_triangles": (pn_triangles.PnTriangles, pn_triangles.Params, {"shading_normals": "linear"}),
    "st_triangles": (st_triangles.StTriangles, st_triangles.Params,
                     {"tension": 0.3, "sharpness": 0.6, "bias": -0.5}),
}  # fmt: skip


@pytest.mark.parametrize("displacement", [{}, TURBULENCE])
@pytest.mark.parametrize("surface", SURFACES)
def test_static_vbo_stores_any_surface_to_the_bit(device, surface, displacement):
    system, params, options = SURFACES[surface]
    drawn = system(device, spool(9), params(7, **options, **displacement))
    stored = StaticVbo(device, spool(9), Params(7, surface=surface, **options, **displacement))
    for prepared in (drawn, stored):
        run(device, prepared)
    run(device, stored, Frame(time=0.4))
    assert as_bytes(stored.result()[0]) == as_bytes(drawn.result()[0])
    assert stored.check().passed


def test_static_vbo_refuses_what_its_surface_cannot_bear(device):
    far = TriangleMesh(icosphere(0).positions * np.float32(2e37), icosphere(0).triangles)
    StaticVbo(device, far, Params(1))
    with pytest.raises(ValueError, match=r"points: expected coordinates up to 1e\+37"):
        StaticVbo(device, far, Params(1, surface="pn_triangles"))


def test_static_vbo_streams_large_outputs_to_the_same_bits(device):
    mesh = plane(19, 15)  # more than the 16 MiB that stay in caches, ending within a vector
    drawn = pattern.Pattern(device, mesh, pattern.Params(61))
    stored = StaticVbo(device, mesh, Params(61))
    run(device, stored)
    assert stored.footprint().output_bytes > 16 << 20
    assert as_bytes(stored.result()[0]) == as_bytes(drawn.result()[0])


def test_static_vbo_stands_still(device):
    stored = StaticVbo(device, icosphere(1), Params(4, amplitude=0.05))
    run(device, stored, Frame(time=0.0))
    first = as_bytes(stored.result()[0])
    run(device, stored, Frame(time=0.4))
    assert as_bytes(stored.result()[0]) == first
    assert stored.check().passed


def test_static_vbo_writes_its_output_every_frame(device):
    stored = StaticVbo(device, icosphere(1), Params(8))
    first = as_bytes(stored.result()[0])
    (surface,) = stored.output
    assert surface is not None
    for buffer in (surface.positions, surface.normals):
        device.fill(stored.setup, "spoil", buffer, 7.0)
    run(device, stored)
    assert as_bytes(stored.result()[0]) == first


@pytest.mark.parametrize("options", [{"local_size": 1}, {"local_size": 13}, {"one_core": True}])
def test_static_vbo_does_not_depend_on_the_work_group(device, options):
    expected = StaticVbo(device, icosphere(1), Params(5)).result()[0]
    assert as_bytes(StaticVbo(Device.open(**options), icosphere(1), Params(5)).result()[0]) == (
        as_bytes(expected)
    )


def test_static_vbo_stores_as_many_vertices_as_the_paper_says(device):
    mesh = icosphere(1)
    mesh = TriangleMesh(mesh.positions, mesh.triangles[:10])
    stored = StaticVbo(device, mesh, Params(64))
    assert stored.counters()["vertices_square_grid"] == 42_250
    footprint = stored.footprint()
    assert footprint.stored_vertices == footprint.static_vertices == 10 * 2145
    assert footprint.stored_bytes == 10 * (2145 * 24 + 4096 * 12)
    assert "store" in stored.setup.stage_s  # making it is no part of a frame


def test_static_vbo_needs_its_memory():
    with pytest.raises(Unsupported, match=r"needs .* bytes of device memory"):
        StaticVbo(Device.open(memory_limit=400_000), icosphere(1), Params(16))


def test_static_vbo_of_nothing_is_nothing(device):
    stored = StaticVbo(device, TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int)), Params(8))
    run(device, stored)
    assert stored.result()[0].triangle_count == 0
    assert stored.check().passed
