import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings

from lodbench.datasets_gen import catalogue, patches
from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels import tessellate, tessellate_surface
from lodbench.kernels.bezier import borders, lattice, reference
from lodbench.kernels.bezier.vst import Params, Vst
from lodbench.kernels.bezier.vst.reference import tessellated
from lodbench.kernels.opencl import Device, Unsupported
from lodbench.kernels.system import run
from tests.kernels.bezier.patches import NASTY, bicubic, sheet, sheets
from tests.tolerances import UNIT_LENGTH

MODELS = ("teapot", "teacup", "teaspoon", "elephant_gumbo")
GENERATED = {
    "pot": patches.pot(4),
    "cup": patches.cup(),
    "copies": patches.copies(patches.cup(), 3),
}


def made(device, surface, level=3, **options):
    """Points and normals of every patch, (m, n + 1, n + 1, 3) each."""
    prepared = Vst(device, surface, Params(level, **options))
    run(device, prepared)
    (mesh,) = prepared.result()
    side = lattice.side_vertices(level)
    shape = len(surface.points), side, side, 3
    normals = None if mesh.normals is None else mesh.normals.reshape(shape)
    return mesh.positions.reshape(shape), normals


def directed_edges(triangles):
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=-1).reshape(-1, 2)
    return ends.astype(np.int64)


def assert_borders_agree(surface, positions, normals=None):
    """Every border's points, and normals where it is smooth, are those of the first edge of its curve to the bit."""
    found = borders.borders_of(surface.points)
    level = int(np.log2(positions.shape[1] - 1))
    places = lattice.edge_vertices(level)
    flat = [None if a is None else a.reshape(len(a), -1, 3) for a in (positions, normals)]
    for patch in range(len(positions)):
        for edge in range(4):
            other, other_edge = divmod(int(found.owner[patch, edge]), 4)
            against = found.turned[patch, edge] != found.turned[other, other_edge]
            along = places[other_edge][:: -1 if against else 1]
            assert flat[0][patch, places[edge]].tobytes() == flat[0][other, along].tobytes()
            if normals is not None and found.smooth[patch, edge]:
                inner = slice(1, -1)
                here, there = places[edge][inner], along[inner]
                assert flat[1][patch, here].tobytes() == flat[1][other, there].tobytes()


@pytest.mark.parametrize("level", [0, 1, 2, 3, 5])
@pytest.mark.parametrize("name", GENERATED)
def test_vst_gives_the_surface_of_the_reference(device, name, level):
    surface = GENERATED[name]
    positions, normals = made(device, surface, level)
    P = surface.points.astype(np.float64)
    points, directions = tessellated(P, level)
    box = P.reshape(-1, 3)
    diagonal = np.linalg.norm(np.ptp(box, axis=0))
    assert np.abs(positions.reshape(points.shape) - points).max() <= 1e-6 * diagonal
    _, certain = reference.normals_at(P, *lattice.lattice_parameters(level))
    apart = np.linalg.norm(normals.reshape(points.shape) - directions, axis=-1)
    assert apart[certain].max(initial=0) <= np.deg2rad(0.1)
    assert np.abs(np.linalg.norm(normals, axis=-1) - 1).max() <= UNIT_LENGTH
    assert_borders_agree(surface, positions, normals)


@pytest.mark.parametrize("name", MODELS)
def test_vst_of_real_models_passes_its_check(device, data_folder, name):
    surface = catalogue.load(name).surface
    prepared = Vst(device, surface, Params(4))
    run(device, prepared)
    assert prepared.check().passed, prepared.check()
    assert_borders_agree(surface, *made(device, surface, 4))


def test_vst_check_sees_a_wrong_point(device):
    prepared = Vst(device, patches.cup(), Params(2))
    run(device, prepared)
    prepared._patches = BezierPatches(patches.cup().points * (1 + 1e-5))
    assert not prepared.check().passed


@settings(max_examples=20, deadline=None)
@given(sheets)
def test_vst_borders_agree_however_patches_are_named(device, surface):
    positions, normals = made(device, surface, 3)
    assert np.isfinite(positions).all() and np.isfinite(normals).all()
    found = borders.borders_of(surface.points).counts()
    assert (found["shared_edges"], found["open_edges"]) == (4, 8)
    assert_borders_agree(surface, positions, normals)


def test_vst_corners_are_the_control_points(device):
    surface = sheet(3)
    positions, _ = made(device, surface, 4)
    assert np.array_equal(positions[:, ::16, ::16], surface.points[:, ::3, ::3])


@pytest.mark.parametrize(("level", "coarse"), [(5, 2), (4, 3)])
def test_vst_levels_are_nested(device, level, coarse):
    # the map's numbers are among those of the finer one; an inner row's sums are the same
    surface, step = sheet(5), 1 << (level - coarse)
    fine, _ = made(device, surface, level)
    assert np.array_equal(fine[:, ::step, ::step], made(device, surface, coarse)[0])


def test_vst_normals_are_a_part_that_may_be_left_out(device):
    surface = sheet(7)
    alone, none = made(device, surface, 4, normals=False)
    assert none is None
    assert np.array_equal(alone, made(device, surface, 4)[0])


def test_vst_past_the_caches_gives_the_same_bytes(device, monkeypatch):
    surface = patches.copies(sheet(9), 5)
    expected = made(device, surface, 4)
    monkeypatch.setattr("lodbench.kernels.launching.STREAM_BYTES", 0)
    for one, other in zip(expected, made(device, surface, 4), strict=True):
        assert one.tobytes() == other.tobytes()


def test_vst_welds_a_closed_pot_to_a_sphere(device):
    result = tessellate_surface(device, patches.pot(4), level=3, method="vst")
    mesh = result.mesh
    ends = directed_edges(mesh.triangles)
    forward, counts = np.unique(ends, axis=0, return_counts=True)
    assert (counts == 1).all()
    assert {tuple(e) for e in forward} == {tuple(e[::-1]) for e in forward}  # no edge is open
    assert mesh.vertex_count - len(ends) // 2 + mesh.triangle_count == 2
    assert result.counters["collapsed_edges"] == 8
    # 8 edges of 8 segments that collapse: a triangle less each
    assert mesh.triangle_count == 16 * 128 - 8 * 8
    size = np.linalg.norm(mesh.positions - mesh.positions.mean(0), axis=1)
    outwards = ((mesh.positions - mesh.positions.mean(0)) * mesh.normals).sum(1) / size
    assert outwards.min() > -0.7 and outwards.mean() > 0.5


def test_vst_unwelded_has_all_vertices_of_every_patch(device):
    points, faces = tessellate(patches.cup(), level=2, weld=False)
    assert (len(points), len(faces)) == (26 * 25, 26 * 32)
    assert points.dtype == np.float32 and faces.dtype == np.uint32
    welded, kept = tessellate(patches.cup().points, level=2)
    assert len(kept) == 26 * 32 - 4 * 4 and len(welded) < len(points)


def test_vst_pole_has_the_normal_that_it_tends_to(device):
    surface = patches.pot(8)  # the first four patches have their v = 0 at the pole
    _, normals = made(device, surface, 4)
    P = surface.points[:4].astype(np.float64)
    t = np.arange(17) / 16
    along_v = np.diff(P[:, :, :2], axis=2)[:, :, 0]  # control points of Q_v at v = 0
    growing = np.einsum("ni,mik->mnk", reference.bernstein_slopes(t), np.diff(along_v, axis=1))
    limit = np.cross(growing, np.einsum("ni,mik->mnk", reference.bernstein(t), along_v))
    limit /= np.linalg.norm(limit, axis=-1, keepdims=True)
    assert np.abs(normals[:4, :, 0] - limit).max() < np.deg2rad(0.1)


def test_vst_welded_has_the_mean_of_normals_at_a_crease():
    flat = bicubic(0.0).points[0]
    upright = flat[..., [2, 1, 0]] * (1, 1, -1)
    mesh = tessellate_surface(None, BezierPatches(np.stack([flat, upright])), level=1).mesh
    assert (mesh.vertex_count, mesh.triangle_count) == (9 + 9 - 3, 16)
    at_crease = (mesh.positions[:, [0, 2]] == 0).all(axis=1)
    assert at_crease.sum() == 3
    expected = np.abs(mesh.normals[at_crease] @ (np.sqrt(0.5), 0, 0.0))
    assert np.allclose(expected, 0.5)
    inside = mesh.normals[~at_crease]
    assert np.allclose(np.abs(inside).max(axis=1), 1)


def test_vst_creases_keep_the_normals_of_both_sides(device):
    flat = bicubic(0.0).points[0]
    upright = flat[..., [2, 1, 0]] * (1, 1, -1)  # the same border x = 0, at a right angle
    surface = BezierPatches(np.stack([flat, upright]))
    _, normals = made(device, surface, 2)
    assert borders.borders_of(surface.points).counts()["shared_edges"] == 1
    assert borders.borders_of(surface.points).counts()["smooth_edges"] == 0
    assert np.allclose(np.abs(normals[0] @ (0, 0, 1)), 1) and np.allclose(
        np.abs(normals[1] @ (1, 0, 0)), 1
    )


@pytest.mark.parametrize("name", NASTY)
def test_vst_bears_nasty_patches(device, name):
    surface = BezierPatches(NASTY[name])
    for level in (0, 2, 3):
        prepared = Vst(device, surface, Params(level))
        run(device, prepared)
        (mesh,) = prepared.result()
        assert np.isfinite(mesh.positions).all()
        assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=UNIT_LENGTH)
        assert prepared.check().passed
        prepared.welded()


def test_vst_refuses_what_it_cannot_do():
    with pytest.raises(ValueError, match="level: expected 0 to 10, got 30"):
        tessellate(patches.cup(), level=30)
    with pytest.raises(TypeError, match="level: expected a whole number"):
        tessellate(patches.cup(), level=2.5)
    with pytest.raises(ValueError, match=r"points: expected \(n, 4, 4, 3\)"):
        tessellate(np.zeros((2, 3, 3, 3)))
    with pytest.raises(ValueError, match="points: expected"):
        tessellate(np.full((1, 4, 4, 3), np.nan))
    with pytest.raises(ValueError, match=r"points: expected coordinates up to 1e\+36, got 3e\+38"):
        tessellate(np.full((1, 4, 4, 3), 3e38))
    with pytest.raises(TypeError, match="option: expected one"):
        tessellate(patches.cup(), lvl=3)
    with pytest.raises(ValueError, match=r"level: expected at most 2\*\*32 vertices"):
        tessellate(patches.copies(patches.cup(), 200), level=10)


def test_vst_needs_room(device):
    small = Device.open(memory_limit=1 << 20)
    with pytest.raises(Unsupported, match="positions: needs"):
        Vst(small, patches.cup(), Params(7))


def test_vst_stores_the_map_and_the_control_points(device):
    prepared = Vst(device, patches.cup(), Params(5))
    run(device, prepared)
    footprint = prepared.footprint()
    assert footprint.output_bytes == 24 * 26 * 33 * 33
    assert footprint.input_bytes == 26 * 64 * 4
    assert dataclasses.asdict(footprint)["stored_bytes"] < footprint.static_bytes / 4
