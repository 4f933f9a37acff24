"""What both adaptive tessellations promise, asked of each."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen import catalogue, patches
from lodbench.datasets_gen.surfaces import BezierPatches
from lodbench.kernels import tessellate, tessellate_surface
from lodbench.kernels.bezier import borders, dabt, semi_adaptive
from lodbench.kernels.bezier.candidates import (
    INSIDE,
    NODES,
    candidate_masks,
    nodes_of,
    triangle_counts,
    ways_of,
)
from lodbench.kernels.bezier.lattice import edge_vertices, side_vertices
from lodbench.kernels.bezier.measures import SCREEN
from lodbench.kernels.bezier.strips import strips
from lodbench.kernels.bezier.vst import Params as VstParams
from lodbench.kernels.bezier.vst import Vst
from lodbench.kernels.stages.camera import fit_box
from lodbench.kernels.system import Frame, run
from tests.kernels.bezier.patches import NASTY, bicubic, sheets

METHODS = {"dabt": dabt, "semi_adaptive": semi_adaptive}
PUBLISHED = ("distance", "flat", "length")
TESTS = (*PUBLISHED, "mean")
thresholds = {
    "distance": st.sampled_from([0.0, 1e-4, 3e-3, 0.02, 0.1, 1e30]),
    "flat": st.sampled_from([0.0, 1e-3, 0.03, 0.3, 1.5, 1e30]),
    "length": st.sampled_from([0.0, 5.0, 50.0, 300.0, 1e30]),
    "mean": st.sampled_from([0.0, 1e-7, 1e-5, 1e-3, 1e30]),
}
asked = st.sampled_from(TESTS).flatmap(lambda t: st.tuples(st.just(t), thresholds[t]))
both = pytest.mark.parametrize("method", METHODS)


def made(device, surface, method, frame=None, **options):
    kind = METHODS[method]
    prepared = kind.prepare(device, surface, kind.Params(**options))
    run(device, prepared, frame or Frame())
    return prepared


def lattice_mesh(prepared):
    """Patch, virtual vertex, and (u, v) as whole numbers of every vertex, and the triangles."""
    patch, place = prepared.vertex_places()
    side = side_vertices(prepared.map_level)
    (mesh,) = prepared.result()
    assert mesh.vertex_count == len(patch)
    return patch, place, np.stack(np.divmod(place, side), axis=1), mesh


def assert_watertight(prepared):
    """Every patch is tiled once, and where coarse triangles or patches meet they have the same vertices to the bit."""
    patch, place, uv, mesh = lattice_mesh(prepared)
    a, b, c = (uv[mesh.triangles[:, k]] for k in range(3))
    (bx, by), (cx, cy) = (b - a).T, (c - a).T
    area = bx * cy - by * cx
    assert (area > 0).all()  # turning from u to v, none without area
    of_patch = patch[mesh.triangles[:, 0]]
    total = np.bincount(of_patch, area, minlength=prepared.count)
    assert (total == 2 * (side_vertices(prepared.map_level) - 1) ** 2).all()

    welded, count = borders.sharing(prepared._borders, prepared.map_level)
    vertex = welded[patch, place]
    first = np.zeros(count, np.int64)
    first[vertex[::-1]] = np.arange(len(vertex))[::-1]
    assert mesh.positions[first[vertex]].tobytes() == mesh.positions.tobytes()
    # within a patch each edge is that of two triangles: no vertex lies in the middle of one
    n = side_vertices(prepared.map_level) - 1
    inner = ((uv > 0) & (uv < n)).all(axis=1)
    ends = np.stack([mesh.triangles, np.roll(mesh.triangles, -1, axis=1)], axis=-1).reshape(-1, 2)
    ends = ends[inner[ends].any(axis=1)]
    own = patch * (n + 1) ** 2 + place
    _, uses = np.unique(np.sort(own[ends], axis=1), axis=0, return_counts=True)
    assert (uses == 2).all()
    # along a curve all patches have the same
    found = prepared._borders
    on = np.zeros((prepared.count, (n + 1) ** 2), bool)
    on[patch, place] = True
    along = on[:, edge_vertices(prepared.map_level)]
    along = np.where(found.turned[..., None], along[..., ::-1], along).reshape(-1, n + 1)
    assert np.array_equal(along, along[found.owner.ravel()])
    return mesh


@st.composite
def node_masks(draw):
    corners = 1 | 1 << 36 | 1 << 44
    return draw(st.integers(0, (1 << NODES) - 1)) & draw(st.integers(0, (1 << NODES) - 1)) | corners


@settings(max_examples=150, deadline=None)
@given(node_masks())
def test_strips_tile_the_triangle_between_any_nodes(mask):
    row, column = np.tril_indices(9)
    own = np.array([k for k in range(NODES) if mask >> k & 1])
    triangles = np.array(strips(mask))
    (a, b, c) = (np.stack([row[own], column[own]], 1)[triangles[:, k]] for k in range(3))
    (down, across), (more, aside) = (b - a).T, (c - a).T
    area = down * aside - across * more
    assert (area > 0).all() and area.sum() == 64
    flags = nodes_of(np.array([mask], np.uint64))
    assert len(triangles) == triangle_counts(flags)[0]
    assert set(triangles.ravel().tolist()) == set(range(len(own)))
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=-1).reshape(-1, 2)
    directed = {tuple(e) for e in ends.tolist()}
    assert len(directed) == len(ends)
    alone = {e for e in directed if e[::-1] not in directed}
    assert len(alone) == (flags[0] & ~INSIDE).sum()  # the edges, cut at their nodes alone


def test_candidates_of_deeper_levels_hold_those_of_others():
    masks = nodes_of(candidate_masks())
    for first in (0, 4, 8, 12):
        for level in range(3):
            assert (masks[first + level] <= masks[first + level + 1]).all()
    assert (masks[[3, 7, 11]].sum(axis=0) == INSIDE).all()  # thirds do not overlap
    assert (masks[15] == INSIDE).all() and (masks[16] == ~INSIDE).all()


@both
@settings(max_examples=10, deadline=None)
@given(sheets, asked, st.sampled_from([3, 4]))
def test_adaptive_meets_without_cracks_however_patches_are_named(
    device, method, surface, test, level
):
    kind, threshold = test
    prepared = made(device, surface, method, level=level, test=kind, threshold=threshold)
    assert prepared.check().passed, prepared.check()
    assert_watertight(prepared)


@both
@pytest.mark.parametrize("test", TESTS)
def test_adaptive_is_watertight_on_generated_models(device, method, test):
    for surface in (patches.pot(8), patches.cup()):
        prepared = made(device, surface, method, level=4, test=test, quality="medium")
        assert prepared.check().passed, prepared.check()
        mesh = assert_watertight(prepared)
        assert 0 < prepared.live()[1] < len(surface.points) * 2 * 4**4
        assert mesh.triangle_count == prepared.live()[1]


@both
@pytest.mark.parametrize("name", ["teapot", "teacup", "teaspoon", "elephant_gumbo"])
def test_adaptive_of_real_models_passes_its_check(device, data_folder, method, name):
    surface = catalogue.load(name).surface
    for test in TESTS:
        prepared = made(device, surface, method, level=4, test=test)
        assert prepared.check().passed, prepared.check()
    assert_watertight(prepared)


@both
@pytest.mark.parametrize("level", [0, 1, 3, 4])
def test_adaptive_with_threshold_0_has_the_vertices_of_vst(device, method, level):
    surface = patches.cup()
    prepared = made(device, surface, method, level=level, threshold=0.0)
    other = Vst(device, surface, VstParams(level))
    run(device, other)
    side, step = side_vertices(level), 1 << (prepared.map_level - level)
    expected = other.result()[0].positions.reshape(len(surface.points), side, side, 3)
    patch, place, uv, mesh = lattice_mesh(prepared)
    assert (uv % step == 0).all()
    got = expected[patch, uv[:, 0] // step, uv[:, 1] // step]
    diagonal = np.linalg.norm(np.ptp(surface.points.reshape(-1, 3), axis=0))
    assert np.abs(got - mesh.positions).max() <= 1e-6 * diagonal
    border = (uv == 0).any(axis=1) | (uv == side_vertices(prepared.map_level) - 1).any(axis=1)
    assert got[border].tobytes() == mesh.positions[border].tobytes()
    assert (
        len(np.unique(patch * side_vertices(prepared.map_level) ** 2 + place))
        == expected[..., 0].size
    )
    assert mesh.triangle_count == other.live()[1]


@both
@pytest.mark.parametrize("test", TESTS)
def test_adaptive_with_an_infinite_threshold_is_the_coarse_mesh(device, method, test):
    prepared = made(device, patches.cup(), method, level=5, test=test, threshold=1e30)
    assert prepared.live() == (26 * 16 * 6, 26 * 16 * 2)
    assert prepared.counters()["level_0_triangles"] == 26 * 32
    assert prepared.counters()["work_spread"] == 0 and prepared.counters()["lanes_used"] == 1


@both
@settings(max_examples=6, deadline=None)
@given(sheets, st.sampled_from(PUBLISHED))
def test_adaptive_counts_fall_as_thresholds_rise(device, method, surface, test):
    scale = {"distance": 1e-3, "flat": 0.01, "length": 8.0}[test]
    counts = [
        nodes_of(made(device, surface, method, level=3, test=test, threshold=scale * k).masks())
        for k in (0, 1, 4, 16, 64)
    ]
    for finer, coarser in pairwise(counts):
        assert (coarser[..., ~INSIDE] <= finer[..., ~INSIDE]).all()
        assert (coarser <= finer).all()


@both
def test_adaptive_has_fewer_triangles_for_less_quality(device, method):
    surface = patches.cup()
    counts = [
        made(device, surface, method, level=5, quality=quality).live()[1]
        for quality in ("low", "medium", "high")
    ]
    assert counts == sorted(counts) and counts[0] < counts[2]


@both
def test_adaptive_sees_less_from_afar(device, method):
    surface = bicubic(np.outer([0, 1, 1, 0], [0, 1, 1, 0]) / 2)
    options = {"level": 4, "test": "length", "threshold": 20.0}
    prepared = made(device, surface, method, **options)
    counts = {}
    for size in (64, 512, 4096):
        view = fit_box((0, 0, 0), (1, 1, 1), size=(size, size))
        run(device, prepared, Frame(view))
        assert prepared.check().passed
        assert_watertight(prepared)
        counts[size] = prepared.live()[1]
    assert counts[64] < counts[512] < counts[4096]
    run(device, prepared, Frame())
    assert prepared.live() == made(device, surface, method, **options).live()
    assert SCREEN == 1024


@both
def test_adaptive_normals_agree_along_smooth_borders(device, method):
    surface = patches.pot(8)
    prepared = made(device, surface, method, level=4, test="flat")
    patch, place, _, mesh = lattice_mesh(prepared)
    welded, _ = borders.sharing(prepared._borders, prepared.map_level)
    vertex = welded[patch, place]
    shared = prepared.welded()
    assert np.allclose(np.linalg.norm(shared.normals, axis=1), 1, atol=1e-6)
    order = np.argsort(vertex, kind="stable")
    normals = mesh.normals[order].view(np.uint32)
    same = vertex[order][1:] == vertex[order][:-1]
    apart = (normals[1:] != normals[:-1]).any(axis=1) & same
    # poles alone, where patches end in a point, each with its own limit
    rims = np.isin(vertex[order][1:][apart], welded[prepared._borders.collapsed.any(axis=1)])
    assert rims.all()


@both
@pytest.mark.parametrize("test", TESTS)
@pytest.mark.parametrize("name", NASTY)
def test_adaptive_bears_nasty_patches(device, method, name, test):
    for level in (0, 3):
        for threshold in (None, 0.0):
            prepared = made(
                device,
                BezierPatches(NASTY[name]),
                method,
                level=level,
                test=test,
                threshold=threshold,
            )
            (mesh,) = prepared.result()
            assert np.isfinite(mesh.positions).all()
            assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=1e-6)
            assert prepared.check().passed, prepared.check()
            prepared.welded()


@both
def test_adaptive_makes_room_when_it_needs_more(device, method, monkeypatch):
    surface = patches.cup()
    expected = made(device, surface, method, level=4).result()[0]
    monkeypatch.setattr("lodbench.kernels.bezier.adaptive.FIRST_VERTICES", 100)
    monkeypatch.setattr("lodbench.kernels.bezier.adaptive.FIRST_SHARE", 0.0)
    grown = made(device, surface, method, level=4).result()[0]
    assert grown.positions.tobytes() == expected.positions.tobytes()
    assert np.array_equal(grown.triangles, expected.triangles)


@both
def test_adaptive_welds_and_counts(device, method):
    result = tessellate_surface(device, patches.pot(4), level=4, method=method, quality="low")
    triangles = result.mesh.triangles.astype(np.int64)
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=-1).reshape(-1, 2)
    forward, counts = np.unique(ends, axis=0, return_counts=True)
    assert (counts == 1).all()
    assert {tuple(e) for e in forward} == {tuple(e[::-1]) for e in forward}
    assert result.mesh.vertex_count - len(ends) // 2 + len(triangles) == 2
    levels = [result.counters[f"level_{k}_triangles"] for k in range(4)]
    assert sum(levels) == result.counters["coarse_triangles"] == 16 * 8
    assert 0 < result.counters["lanes_used"] <= 1 <= result.counters["launches"]


@both
def test_adaptive_without_normals_has_the_same_points(device, method):
    surface = patches.cup()
    bare = made(device, surface, method, level=4, normals=False).result()[0]
    full = made(device, surface, method, level=4).result()[0]
    assert bare.normals is None
    assert bare.positions.tobytes() == full.positions.tobytes()


def test_both_have_the_same_vertices_on_edges(device):
    for test in PUBLISHED:
        found = [made(device, patches.cup(), m, level=4, test=test).masks() for m in METHODS]
        assert np.array_equal(*(ways_of(masks) for masks in found))
        one, other = (nodes_of(masks)[..., ~INSIDE] for masks in found)
        assert np.array_equal(one, other)


@both
def test_adaptive_refuses_what_it_cannot_do(method):
    for options, text in (
        ({"test": "round"}, "test: expected one of distance, flat, length, mean, got 'round'"),
        ({"quality": "best"}, "quality: expected one of high, medium, low"),
        ({"threshold": -1.0}, "threshold: expected at least 0, got -1.0"),
        ({"depth": 4}, "depth: expected 0 to 3, got 4"),
        ({"level": 30}, "level: expected 0 to 10, got 30"),
    ):
        with pytest.raises(ValueError, match=text):
            tessellate(patches.cup(), method=method, **options)
    with pytest.raises(ValueError, match=r"points: expected coordinates up to 1e\+36, got 3e\+38"):
        tessellate(np.full((1, 4, 4, 3), 3e38), method=method)
