import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen import patches
from lodbench.datasets_gen.finest import finest
from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels import tessellate, tessellate_surface
from lodbench.kernels.bezier import borders, gst, vst, vsthd
from lodbench.kernels.render import mesh_view
from lodbench.kernels.system import Frame, run
from tests.kernels.bezier.patches import NASTY, sheets
from tests.tolerances import UNIT_LENGTH

SYSTEMS = {
    "vst": vst,
    "gst": gst,
    "vsthd": vsthd,
}


def made(device, name, surface, frame=None, **params):
    module = SYSTEMS[name]
    prepared = module.SYSTEM.prepare(device, surface, module.Params(**params))
    run(device, prepared, frame or Frame())
    check = prepared.check()
    assert check.passed, check
    return prepared, prepared.result()[0]


def assert_watertight(surface, prepared, mesh):
    """Along every shared border both sides have the same points, and normals where it is smooth, to the bit."""
    found = borders.borders_of(surface.points)
    patch, i, j = prepared.vertices()
    n = 1 << prepared.finest
    sides = [i == 0, i == n, j == 0, j == n]
    for p in range(len(surface.points)):
        for edge in range(4):
            other, other_edge = divmod(int(found.owner[p, edge]), 4)
            here, there = (patch == p) & sides[edge], (patch == other) & sides[other_edge]
            assert {x.tobytes() for x in mesh.positions[here]} == {
                x.tobytes() for x in mesh.positions[there]
            }
            if mesh.normals is not None and found.smooth[p, edge]:
                inner = (i > 0) & (i < n) if edge >= 2 else (j > 0) & (j < n)
                further = (i > 0) & (i < n) if other_edge >= 2 else (j > 0) & (j < n)
                assert {x.tobytes() for x in mesh.normals[here & inner]} == {
                    x.tobytes() for x in mesh.normals[there & further]
                }


@settings(max_examples=8, deadline=None)
@given(
    sheets,
    st.lists(st.integers(0, 4), min_size=4, max_size=4),
    st.sampled_from(sorted(SYSTEMS)),
    st.booleans(),
)
def test_neighbours_of_any_levels_agree_to_the_bit(device, surface, levels, name, normals):
    prepared, mesh = made(device, name, surface, levels=levels, normals=normals)
    assert_watertight(surface, prepared, mesh)
    counts = prepared.counters()
    assert counts["triangles"] == sum(2 * 4**level for level in levels) == mesh.triangle_count
    assert (counts["least_level"], counts["most_level"]) == (min(levels), max(levels))


@pytest.mark.parametrize("name", SYSTEMS)
def test_levels_of_a_closed_pot_leave_no_crack(device, name):
    surface = patches.pot(4)
    levels = np.random.default_rng(3).integers(0, 5, 16)
    result = tessellate_surface(device, surface, method=name, levels=levels)
    mesh = result.mesh
    ends = np.stack([mesh.triangles, np.roll(mesh.triangles, -1, axis=1)], axis=-1).reshape(-1, 2)
    edges, counts = np.unique(ends.astype(np.int64), axis=0, return_counts=True)
    assert (counts == 1).all()
    assert {tuple(e) for e in edges} == {tuple(e[::-1]) for e in edges}  # no edge is open
    assert mesh.vertex_count - len(ends) // 2 + mesh.triangle_count == 2
    assert np.abs(np.linalg.norm(mesh.normals, axis=1) - 1).max() <= UNIT_LENGTH


@pytest.mark.parametrize("name", SYSTEMS)
def test_equal_levels_are_those_of_the_fixed_map(device, name):
    surface, module = patches.cup(), SYSTEMS[name]
    _, mesh = made(device, name, surface, levels=[3] * 26)
    fixed = module.SYSTEM.prepare(device, surface, module.Params(3))
    run(device, fixed)
    (expected,) = fixed.result()
    assert np.array_equal(mesh.triangles, expected.triangles)
    assert np.array_equal(mesh.positions, expected.positions)
    assert np.abs(mesh.normals - expected.normals).max() < np.deg2rad(0.1)


@pytest.mark.parametrize("name", SYSTEMS)
def test_levels_by_the_screen_are_those_of_the_borders_in_view(device, name):
    surface = patches.pot(4)
    triangles = []
    for size in ((40, 32), (160, 128), (640, 512)):
        view = mesh_view(finest(surface), size=size)
        prepared, mesh = made(device, name, surface, Frame(view), level=5, by="screen", pixels=6.0)
        assert_watertight(surface, prepared, mesh)
        levels, edges = prepared.levels_of_last()
        assert np.array_equal(levels, edges.max(axis=1))
        sides = [surface.points[:, 0], surface.points[:, 3]]
        sides += [surface.points[:, :, 0], surface.points[:, :, 3]]
        points = np.stack(sides, axis=1).astype(np.float64)
        clip = points @ view.world_to_clip[:, :3].T + view.world_to_clip[:, 3]
        pixels = clip[..., :2] / clip[..., 3:] * np.array(size) / 2
        length = np.linalg.norm(np.diff(pixels, axis=2), axis=-1).sum(-1)
        expected = np.clip(np.ceil(np.log2(np.maximum(length / 6.0, 1e-9))), 0, 5)
        near = np.abs(np.log2(np.maximum(length / 6.0, 1e-9)) % 1) < 1e-3
        assert np.array_equal(edges[~near], expected[~near])
        triangles.append(mesh.triangle_count)
    assert triangles == sorted(set(triangles))


def test_a_frame_without_a_view_is_the_finest_and_views_take_turns(device):
    surface = patches.cup()
    prepared, mesh = made(device, "vst", surface, level=4, by="screen")
    assert mesh.triangle_count == 26 * 2 * 4**4
    far = Frame(mesh_view(finest(surface), size=(40, 32)))
    run(device, prepared, far)
    few = prepared.result()[0]
    assert few.triangle_count < mesh.triangle_count
    run(device, prepared)
    again = prepared.result()[0]
    assert again.positions.tobytes() == mesh.positions.tobytes()


@pytest.mark.parametrize("what", NASTY)
def test_levels_bear_nasty_patches(device, what, name="vst"):
    surface = BezierPatches(NASTY[what])
    view = mesh_view(finest(surface), size=(64, 48))
    prepared, mesh = made(device, name, surface, Frame(view), level=3, by="screen")
    assert np.isfinite(mesh.positions).all()
    prepared.welded()
    made(device, name, surface, levels=np.arange(len(surface.points)) % 3)


def test_levels_that_are_none_are_refused():
    surface = patches.cup()
    for levels, error, said in (
        ([1, 2], ValueError, "levels: expected one for each of 26 patches, got 2"),
        ([11] * 26, ValueError, "levels: expected 0 to 10, got 11 to 11"),
        ([0.5] * 26, TypeError, "levels: expected .* whole numbers"),
        ([[1] * 26], TypeError, "levels: expected .* whole numbers"),
    ):
        with pytest.raises(error, match=said):
            tessellate(surface, levels=levels)
    with pytest.raises(ValueError, match="levels: expected by='level'"):
        tessellate(surface, levels=[1] * 26, by="screen")
    with pytest.raises(TypeError, match="view: expected"):
        tessellate(surface, by="screen", view=(30, 20))


def test_a_view_asks_for_levels_by_the_screen():
    surface = patches.cup()
    view = mesh_view(finest(surface), size=(64, 48))
    _, faces = tessellate(surface, level=5, view=view)
    assert 26 * 2 < len(faces) < 26 * 2 * 4**5 / 8
