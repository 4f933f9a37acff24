import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen import catalogue, nurbs
from lodbench.datasets_gen.nurbs_surface import NurbsModel, NurbsSurface
from lodbench.harness.measure.exact_nurbs import scipy_points
from lodbench.kernels import tessellate, tessellate_surface
from lodbench.kernels.nurbs.params import BASES
from lodbench.kernels.nurbs.samples import numbers
from lodbench.kernels.nurbs.uniform_nurbs import Params, UniformNurbs
from lodbench.kernels.nurbs.uniform_nurbs.reference import tessellated
from lodbench.kernels.opencl import Device, Unsupported
from lodbench.kernels.system import run
from tests.kernels.nurbs.surfaces import models, random_surface
from tests.tolerances import EPSILON32, UNIT_LENGTH

GENERATED = {
    "cylinder": nurbs.cylinder(),
    "ball": nurbs.ball(),
    "torus": nurbs.torus(),
    "mixed": nurbs.mixed_degrees(),
    "body": nurbs.body(2, 3, (4, 5)),
}
MODELS = (
    "killeroo", "ducky", "hammer_nd", "aorta_valve", "nacelle", "aircraft_wing", "egg",
    "cylinder_rational", "hammer_occ",
)  # fmt: skip


def made(device, model, *values, **options):
    prepared = UniformNurbs(device, model, Params(*values, **options))
    run(device, prepared)
    return prepared


def grids_of(prepared):
    """Points of each surface, (rows, columns, 3)."""
    (mesh,) = prepared.result()
    return [
        mesh.positions[g.first : g.first + g.vertices].reshape(g.rows, g.columns, 3)
        for g in prepared.grids
    ]


def assert_near_scipy(prepared):
    low, high = prepared.model.box
    size = max(np.linalg.norm(high - low), np.abs([low, high]).max())
    for surface, grid, points in zip(
        prepared.model.surfaces, prepared.grids, grids_of(prepared), strict=True
    ):
        u, v = numbers(surface.knots_u, grid.u), numbers(surface.knots_v, grid.v)
        assert np.abs(points - scipy_points(surface, u, v)).max() <= 1e-6 * size


@pytest.mark.parametrize("per", ["surface", "span"])
@pytest.mark.parametrize("name", GENERATED)
def test_uniform_nurbs_gives_the_surfaces_of_scipy(device, name, per):
    for level in (0, 1, 3):
        prepared = made(device, GENERATED[name], level, per)
        assert_near_scipy(prepared)
        assert prepared.check().passed, prepared.check()
        (mesh,) = prepared.result()
        assert np.abs(np.linalg.norm(mesh.normals, axis=1) - 1).max() <= UNIT_LENGTH


@pytest.mark.parametrize("name", MODELS)
def test_uniform_nurbs_of_real_models(device, data_folder, name):
    model = catalogue.load(name).surface.recentred()[0]
    prepared = made(device, model, 3)
    assert_near_scipy(prepared)
    assert prepared.check().passed, prepared.check()
    assert_borders_agree(prepared)


def assert_borders_agree(prepared):
    positions = prepared.result()[0].positions
    normals = prepared.result()[0].normals
    found = prepared.shared
    assert positions[found.vertices].tobytes() == positions[found.roots].tobytes()
    smooth = found.vertices[found.smooth], found.roots[found.smooth]
    assert normals[smooth[0]].tobytes() == normals[smooth[1]].tobytes()


@settings(max_examples=10, deadline=None)
@given(models(), st.integers(0, 4), st.sampled_from(["surface", "span"]), st.sampled_from(BASES))
def test_uniform_nurbs_of_any_degrees_knots_and_weights(device, model, level, per, basis):
    prepared = made(device, model, level, per, basis)
    assert_near_scipy(prepared)
    assert prepared.check().passed, prepared.check()


def test_uniform_nurbs_is_the_reference(device):
    model, params = nurbs.mixed_degrees(2), Params(3)
    prepared = made(device, model, 3)
    for got, (points, _) in zip(grids_of(prepared), tessellated(model, params), strict=True):
        assert np.abs(got - points).max() <= 1e-6 * model.diagonal


def test_conics_are_exact_to_float32(device):
    near = 8 * EPSILON32
    for per in ("surface", "span"):
        (points,) = grids_of(made(device, nurbs.ball(), 5, per))
        assert np.abs(np.linalg.norm(points.astype(np.float64), axis=-1) - 1).max() <= near
        (points,) = grids_of(made(device, nurbs.cylinder(1.0), 5, per))
        around = np.linalg.norm(points[..., :2].astype(np.float64), axis=-1)
        assert np.abs(around - 1).max() <= near
        (mesh,) = made(device, nurbs.torus(1, 0.5), 5, per).result()
        p = mesh.positions.astype(np.float64)
        around = np.linalg.norm(p[:, :2], axis=1) - 1
        assert np.abs(np.hypot(around, p[:, 2]) - 0.5).max() <= 2 * near
        normal = np.column_stack([p[:, :2] * (around / (around + 1))[:, None], p[:, 2]]) * 2
        assert np.abs(np.abs((normal * mesh.normals).sum(1)) - 1).max() <= 1e-5


def test_ball_has_normals_at_its_poles(device):
    (mesh,) = made(device, nurbs.ball(), 4).result()
    assert np.abs((mesh.positions * mesh.normals).sum(axis=1) - 1).max() <= 1e-5


def test_corners_are_the_control_points(device):
    surface = random_surface((3, 5), (3, 2), 4)
    (points,) = grids_of(made(device, NurbsModel((surface,)), 3))
    expected = surface.points[::, ::][[0, 0, -1, -1], [0, -1, 0, -1]]
    assert np.abs(points[[0, 0, -1, -1], [0, -1, 0, -1]] - expected).max() <= 2 * EPSILON32


def test_uniform_nurbs_welds_closed_bodies(device):
    for model, level, characteristic in (
        (nurbs.body(2, 3, (4, 5)), 3, 0), (nurbs.torus(), 4, 0), (nurbs.ball(), 4, 2),
    ):  # fmt: skip
        result = tessellate_surface(device, model, level=level)
        mesh = result.mesh
        ends = np.stack([mesh.triangles, np.roll(mesh.triangles, -1, axis=1)], -1).reshape(-1, 2)
        edges, counts = np.unique(ends.astype(np.int64), axis=0, return_counts=True)
        assert (counts == 1).all()
        assert {tuple(e) for e in edges} == {tuple(e[::-1]) for e in edges}  # none is open
        assert mesh.vertex_count - len(edges) // 2 + mesh.triangle_count == characteristic
        assert len(mesh.positions) == len(np.unique(mesh.positions, axis=0))


def test_uniform_nurbs_has_a_mesh_for_each_surface(device):
    model = nurbs.body(2, 3, (4, 5))
    result = tessellate_surface(device, dataclasses.replace(model, names=tuple("abcdef")), level=2)
    assert list(result.parts) == list("abcdef")
    assert all(
        part.triangle_count == 32 and part.normals is not None for part in result.parts.values()
    )
    assert result.counters["surfaces"] == 6 and result.counters["quads"] == 120
    folded = tessellate_surface(device, nurbs.ball(), level=3).parts["surface_0"]
    assert folded.triangle_count == 128 - 16


def test_uniform_nurbs_far_from_zero_keeps_its_bits(device):
    (ball,) = nurbs.ball().surfaces
    far = NurbsModel((dataclasses.replace(ball, points=ball.points + 1e6),))
    mesh = tessellate_surface(device, far, level=3).mesh
    assert mesh.origin is not None
    assert np.abs(np.linalg.norm(mesh.points - 1e6, axis=1) - 1).max() <= 8 * EPSILON32


def test_uniform_nurbs_past_the_caches_gives_the_same_bytes(device, monkeypatch):
    model = nurbs.body(2, 3, (4, 5))
    expected = [
        mesh.positions.tobytes() + mesh.normals.tobytes()
        for mesh in made(device, model, 4).result()
    ]
    monkeypatch.setattr("lodbench.kernels.launching.STREAM_BYTES", 0)
    got = [
        mesh.positions.tobytes() + mesh.normals.tobytes()
        for mesh in made(device, model, 4).result()
    ]
    assert got == expected


@pytest.mark.parametrize("rational", [False, True])
@pytest.mark.parametrize("degrees", [(2, 3), (7, 5)])
def test_uniform_nurbs_gives_long_rows_the_same_bytes_however_they_are_cut(
    device, monkeypatch, degrees, rational
):
    model = NurbsModel(tuple(random_surface(degrees, (2, k), 3, rational) for k in (1, 2, 5)))
    whole = made(device, model, 7)
    assert_near_scipy(whole)
    assert whole.check().passed
    for chunk, group in ((8, 1), (40, 2), (1 << 15, 1)):
        monkeypatch.setattr("lodbench.kernels.nurbs.vertices.LONG_CHUNK", chunk)
        monkeypatch.setattr("lodbench.kernels.nurbs.vertices.LONG_GROUP", group)
        (cut,), (one,) = made(device, model, 7).result(), whole.result()
        assert cut.positions.tobytes() == one.positions.tobytes()
        assert cut.normals.tobytes() == one.normals.tobytes()


@pytest.mark.parametrize("degrees", [(3, 3), (1, 2), (7, 5)])
def test_uniform_nurbs_gives_points_alone_the_same_bytes_however_they_are_cut(
    device, monkeypatch, degrees
):
    model = NurbsModel(tuple(random_surface(degrees, (k, 4), k, False) for k in (1, 2, 9)))
    for level in (0, 1, 6):
        whole = made(device, model, level, normals=False)
        assert_near_scipy(whole)
        assert whole.check().passed
        (one,), (beside,) = whole.result(), made(device, model, level).result()
        assert np.abs(one.positions - beside.positions).max() <= 1e-6
        for vertices in (8, 100):
            with monkeypatch.context() as patch:
                patch.setattr("lodbench.kernels.nurbs.vertices.TILE_VERTICES", vertices)
                patch.setattr("lodbench.kernels.nurbs.vertices.TILES", 1 << 10)
                (cut,) = made(device, model, level, normals=False).result()
            assert cut.positions.tobytes() == one.positions.tobytes()


def test_uniform_nurbs_normals_are_a_part_that_may_be_left_out(device):
    model = nurbs.mixed_degrees()
    alone = made(device, model, 3, normals=False).result()[0]
    assert alone.normals is None
    assert np.array_equal(alone.positions, made(device, model, 3).result()[0].positions)


def nasty(points, weights=None, degree=2):
    knots = np.r_[np.zeros(degree + 1), 0.5, np.ones(degree + 1)]
    return NurbsModel((NurbsSurface(degree, degree, knots, knots, points, weights),))


FLAT = np.stack([*np.meshgrid(np.arange(4.0), np.arange(4.0), indexing="ij"), np.zeros((4, 4))], 2)


@pytest.mark.parametrize(
    "model",
    [
        nasty(np.zeros((4, 4, 3))),
        nasty(FLAT * (1, 0, 0)),
        nasty(FLAT * 1e-30),
        nasty(FLAT * 1e29),
        nasty(FLAT, np.geomspace(1e-6, 1e6, 16).reshape(4, 4)),
        nasty(FLAT, np.full((4, 4), 1e-200)),
        nasty(np.repeat(FLAT[:1], 4, axis=0)),
    ],
    ids=["point", "line", "small", "large", "weights", "light", "edge"],
)
def test_uniform_nurbs_bears_nasty_surfaces(device, model):
    for per in ("surface", "span"):
        prepared = made(device, model, 3, per)
        (mesh,) = prepared.result()
        assert np.isfinite(mesh.positions).all()
        assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=UNIT_LENGTH)
        assert prepared.check().passed, prepared.check()
        prepared.welded(), prepared.parts()


def test_uniform_nurbs_refuses_what_it_cannot_do(device):
    with pytest.raises(ValueError, match="level: expected 0 to 10, got 30"):
        tessellate(nurbs.ball(), level=30)
    with pytest.raises(ValueError, match="per: expected one of surface, span"):
        tessellate(nurbs.ball(), per="knot")
    with pytest.raises(ValueError, match=r"points: expected coordinates up to 1e\+30, got 3e\+38"):
        tessellate(nasty(FLAT * 1e38))
    with pytest.raises(TypeError, match="option: expected one"):
        tessellate(nurbs.ball(), lvl=3)
    with pytest.raises(TypeError, match="method: expected rpns, uniform_nurbs"):
        tessellate(nurbs.ball(), method="vst")
    with pytest.raises(Unsupported, match="level: needs"):
        tessellate(nurbs.body(), level=10, per="span")
    with pytest.raises(Unsupported, match="needs"):
        UniformNurbs(Device.open(memory_limit=1 << 20), nurbs.ball(), Params(9))


def test_uniform_nurbs_check_sees_a_wrong_point(device):
    prepared = made(device, nurbs.ball(), 3)
    (ball,) = nurbs.ball().surfaces
    prepared.model = NurbsModel((dataclasses.replace(ball, points=ball.points * (1 + 1e-5)),))
    assert not prepared.check().passed
