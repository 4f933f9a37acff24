from itertools import product

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere, plane, torus
from lodbench.kernels import refine, refine_mesh
from lodbench.kernels.refine import pattern as uniform
from lodbench.kernels.refine import pn_triangles
from lodbench.kernels.refine.adaptive_patterns import AdaptivePatterns, Params
from lodbench.kernels.refine.adaptive_patterns.pool import INSIDE, Pattern, pool, snapped
from lodbench.kernels.refine.adaptive_patterns.reference import edge_depths
from lodbench.kernels.stages import scan
from lodbench.kernels.stages.camera import orbit
from lodbench.kernels.system import Frame, run
from tests.kernels.refine.test_pattern import shaken, tetrahedron

EVERY = list(product(range(6), repeat=3))
SOME = [(0, 0, 0), (1, 0, 0), (2, 1, 3), (3, 3, 3), (0, 4, 2), (5, 0, 3), (4, 5, 5)]
PERLIN = {"displacement": "perlin", "amplitude": 0.03, "waves": 5.0}
quick = settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def draw(device, mesh, segments=8, depths=None, view=None, **params):
    options = {"by": "given"} if depths is not None else {}
    prepared = AdaptivePatterns(device, mesh, Params(segments, **options | params), depths)
    run(device, prepared, Frame(view, 0.7))
    return prepared


def euler(mesh):
    """The characteristic, and how many triangles each edge has."""
    edges = np.sort(mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    found, uses = np.unique(edges, axis=0, return_counts=True)
    return len(np.unique(mesh.triangles)) - len(found) + mesh.triangle_count, uses


def doubled_areas(weights, triangles):
    a, b, c = (weights[triangles[:, k], 1:] for k in range(3))
    return (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]


@pytest.mark.parametrize("depths", EVERY, ids=str)
def test_pattern_covers_the_triangle_once(depths):
    made = Pattern(depths)
    n, triangles = 1 << max(depths), made.triangles.astype(np.int64)
    areas = doubled_areas(made.integer_weights, triangles)
    assert (areas > 0).all()
    assert areas.sum() == n * n
    half = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    numbers, back = half @ (len(made.used), 1), half[:, ::-1] @ (len(made.used), 1)
    assert len(np.unique(numbers)) == len(numbers)
    assert (~np.isin(numbers, back)).sum() == sum(1 << d for d in depths)
    for edge, depth in enumerate(depths):
        on = made.integer_weights[made.integer_weights[:, edge] == 0][:, (edge + 1) % 3]
        assert sorted(on) == list(range(0, n + 1, n >> depth))


@pytest.mark.parametrize("depths", EVERY, ids=str)
def test_last_row_is_the_edge_that_comes_last(depths):
    made = Pattern(depths)
    assert (made.integer_weights[: made.last_row, 0] > 0).all()
    assert (made.integer_weights[made.last_row :, 0] == 0).all()


@pytest.mark.parametrize(
    ("depths", "triangles", "vertices"),
    [
        ((0, 0, 0), 1, 3), ((1, 0, 0), 2, 4), ((1, 1, 0), 3, 5), ((2, 0, 0), 10, 9),
        ((5, 0, 0), 962, 499), ((3, 4, 5), 984, 521), ((5, 5, 5), 1024, 561),
    ],
)  # fmt: skip
def test_pattern_has_its_counts(depths, triangles, vertices):
    made = Pattern(depths)
    assert (len(made.triangles), len(made.used)) == (triangles, vertices)


@pytest.mark.parametrize(
    ("finest", "triangles"), [(0, 1), (1, 20), (2, 249), (3, 2_260), (4, 16_553), (5, 105_480)]
)
def test_pool_holds_every_pattern(finest, triangles):
    made = pool(finest)
    assert len(made.vertex_counts) == (finest + 1) ** 3
    assert len(made.triangles) == made.triangle_counts.sum() == triangles
    assert made.records[-1, 1] == triangles


@pytest.mark.parametrize("step", [1, 2, 4, 8, 16])
def test_places_along_an_edge_go_to_the_nearest_that_it_keeps(step):
    n = 16
    t = np.arange(n + 1)
    to = snapped(t, n, step)
    assert (to % step == 0).all()
    assert (np.abs(to - t) <= step / 2).all()
    assert (np.diff(to) >= 0).all()


@pytest.mark.parametrize("depths", EVERY, ids=str)
def test_what_the_finest_level_adds_lies_in_the_middle_of_what_was_there(depths):
    made = Pattern(depths)
    weights, n = made.integer_weights, 1 << max(depths)
    own, one, other, kind = made.moves.astype(np.int64).T
    assert len(np.unique(own)) == len(own)
    inside = kind == INSIDE
    for edge in range(3):
        on = kind == edge
        assert (weights[own[on], edge] == 0).all()
        assert on.sum() == (1 << depths[edge]) // 2
        assert np.array_equal(2 * weights[own[on]], weights[one[on]] + weights[other[on]])
    assert (weights[own[inside]] > 0).all()
    assert (
        inside.sum() == ((weights > 0).all(1) & (weights % 2 == 1).any(1)).sum() if n > 1 else True
    )
    # what stands between stays, or has come from its own edge before
    assert not np.isin(np.r_[one[inside], other[inside]], own[inside]).any()
    assert not np.isin(np.r_[one[~inside], other[~inside]], own[~inside]).any()


@pytest.mark.parametrize("depths", [d for d in EVERY if 0 < max(d) < 5], ids=str)
def test_a_level_that_only_begins_is_the_surface_of_the_one_before(depths):
    made = Pattern(depths)
    before = Pattern(tuple(min(d, max(depths) - 1) for d in depths))
    random = np.random.default_rng(sum(depths))
    heights = random.random(len(before.used))
    places = 2 * before.integer_weights
    values = np.zeros((len(made.used), 4))  # where it is, and a height
    values[:, :3] = made.integer_weights
    look = {tuple(place): height for place, height in zip(places, heights, strict=True)}
    for k, place in enumerate(made.integer_weights):
        values[k, 3] = look.get(tuple(place), 0)
    for own, one, other, kind in made.moves.tolist():
        if kind == INSIDE or depths[kind] == max(depths):
            values[own] = (values[one] + values[other]) / 2
    # each triangle's middle lies on one of the coarser triangles
    middles = values[made.triangles].mean(axis=1)
    middles = middles[np.abs(doubled_areas(values[:, :3], made.triangles)) > 1e-9]
    corners = places[before.triangles].astype(float)
    solved = np.einsum("mij,kj->mki", np.linalg.inv(corners.swapaxes(1, 2)), middles[:, :3])
    holder = solved.min(axis=2).argmax(axis=0)
    at = solved[holder, np.arange(len(middles))]
    assert at.min() > -1e-9
    expected = (at * heights[before.triangles[holder]]).sum(axis=1)
    np.testing.assert_allclose(middles[:, 3], expected, atol=1e-12)


@pytest.mark.parametrize("surface", ["flat", "pn_triangles", "st_triangles"])
@pytest.mark.parametrize("morph", [False, True])
@pytest.mark.parametrize(
    "make", [tetrahedron, lambda: plane(2), lambda: shaken(icosphere(1)), lambda: torus(9, 7)]
)
def test_adaptive_patterns_agree_with_reference(device, make, surface, morph):
    mesh = make()
    depths = np.random.default_rng(3).random(mesh.vertex_count) * 4
    options = {"surface": surface, "geomorphing": morph}
    options |= {"sharpness": 0.7, "tension": 0.3} if surface == "st_triangles" else {}
    for more in ({}, PERLIN):
        check = draw(device, mesh, 16, depths, **options, **more).check()
        assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"


@quick
@given(
    seed=st.integers(0, 2**32 - 1),
    surface=st.sampled_from(["flat", "pn_triangles"]),
    morph=st.booleans(),
    raised=st.booleans(),
    whole=st.booleans(),
    ring=st.booleans(),
)
def test_random_tags_leave_closed_meshes_closed(device, seed, surface, morph, raised, whole, ring):
    random = np.random.default_rng(seed)
    mesh = torus(7, 5) if ring else shaken(icosphere(1), seed % 1000)
    depths = random.random(mesh.vertex_count) * 5 - 0.5
    made = draw(
        device, mesh, 16, np.round(depths) if whole else depths,
        surface=surface, geomorphing=morph, **(PERLIN if raised else {}),
    )  # fmt: skip
    soup = made.result()[0]
    _, one = np.unique(soup.positions + np.float32(0), axis=0, return_inverse=True)
    by_position = TriangleMesh(
        soup.positions[np.unique(one, return_index=True)[1]], one.reshape(-1)[soup.triangles]
    )
    characteristic, uses = euler(by_position)
    assert (uses == 2).all(), "no edge is open, by exact position"
    assert characteristic == (0 if ring else 2)
    assert made.welded().vertex_count == by_position.vertex_count, "none are one by chance"
    normals = np.unique(np.hstack([soup.positions, soup.normals]) + np.float32(0), axis=0)
    assert len(normals) == by_position.vertex_count, "normals agree where points do"


@pytest.mark.parametrize("depth", [0, 1, 2, 3, 4])
@pytest.mark.parametrize("surface", ["flat", "pn_triangles"])
def test_equal_tags_give_the_uniform_pattern_to_the_bit(device, depth, surface):
    mesh = shaken(icosphere(1))
    made = draw(device, mesh, 16, np.full(mesh.vertex_count, depth), surface=surface)
    system = uniform if surface == "flat" else pn_triangles
    even = system.SYSTEM.prepare(device, mesh, system.Params(1 << depth))
    run(device, even)
    for one, other in ((made.result()[0], even.result()[0]), (made.welded(), even.welded())):
        assert np.array_equal(one.positions, other.positions)
        assert np.array_equal(one.normals, other.normals)
        assert one.triangle_count == other.triangle_count


def test_a_users_function_raises_adaptive_triangles_without_cracks(device):
    ball = shaken(icosphere(1))
    mesh = TriangleMesh(ball.positions, ball.triangles, uvs=ball.positions[:, :2])
    text = """float displace(float3 position, float3 normal, float2 uv, float time) {
        return 0.02f * sin(9.0f * position.x) * uv.y + 0.01f * time;
    }"""
    depths = np.random.default_rng(5).random(mesh.vertex_count) * 4
    for morph in (False, True):
        made = draw(
            device, mesh, 16, depths, displacement="function", function=text, geomorphing=morph
        )
        assert made.check().passed, made.check()
        points = made.result()[0].positions + np.float32(0)
        assert len(np.unique(points, axis=0)) == made.welded().vertex_count


@quick
@given(seed=st.integers(0, 2**32 - 1), vertex=st.integers(0, 41))
def test_raising_a_tag_never_takes_triangles_away(device, seed, vertex):
    mesh = icosphere(1)
    depths = np.random.default_rng(seed).random(mesh.vertex_count) * 4
    more = depths.copy()
    more[vertex] += 1
    few, many = (draw(device, mesh, 32, tags).counters()["triangles"] for tags in (depths, more))
    assert few <= many


def test_depths_of_an_edge_are_the_same_from_both_sides():
    mesh = icosphere(2)
    tags = (np.random.default_rng(0).random(mesh.vertex_count) * 5).astype(np.float32)
    depths, blends = edge_depths(mesh.triangles, tags, 5)
    ends = np.stack([np.roll(mesh.triangles, -1, 1), np.roll(mesh.triangles, -2, 1)], 2)
    ends = np.sort(ends.reshape(-1, 2), axis=1)
    _, edge = np.unique(ends, axis=0, return_inverse=True)
    for values in (depths.ravel(), blends[:, :3].ravel()):
        assert all(len(np.unique(values[edge.reshape(-1) == e])) == 1 for e in range(20))


def test_whole_tags_round_half_up():
    triangle = np.array([[0, 1, 2]], np.uint32)
    depths, _ = edge_depths(triangle, np.array([0, 1, 4], np.float32), 5)
    assert depths.tolist() == [[3, 2, 1]]


@pytest.mark.parametrize("by", ["distance", "screen", "mixed"])
def test_the_farther_the_eye_the_fewer_triangles(device, by):
    mesh = shaken(icosphere(2))
    counts = []
    prepared = AdaptivePatterns(device, mesh, Params(32, by=by, tolerance=1e-5, pixels=4))
    for distance in (1.5, 6, 24, 96, 400):
        run(device, prepared, Frame(orbit((0, 0, 0), distance)))
        assert prepared.check().passed
        counts.append(prepared.counters()["triangles"])
    assert counts == sorted(counts, reverse=True)
    assert counts[0] > 8 * counts[-1]
    assert counts[-1] >= mesh.triangle_count


def test_segments_are_as_long_on_the_screen_as_was_asked(device):
    mesh, view = icosphere(2), orbit((0, 0, 0), 3.0)
    made = draw(device, mesh, 128, view=view, by="screen", pixels=6.0, surface="flat").welded()
    clip = np.c_[made.positions, np.ones(made.vertex_count)] @ view.world_to_clip.T
    pixel = clip[:, :2] / clip[:, 3:] * (view.width / 2, view.height / 2)
    edges = made.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    longest = np.linalg.norm(pixel[edges[:, 0]] - pixel[edges[:, 1]], axis=1).max()
    assert 3.0 < longest < 8.0, "mean lengths of edges, and nearer than their ends"


def test_curvature_leaves_flat_parts_coarse(device):
    sheet = plane(8)
    points = np.asarray(sheet.positions, np.float64)
    points[:, 2] = 0.5 * np.maximum(points[:, 0] - 0.5, 0) ** 2
    mesh = TriangleMesh(points, sheet.triangles)
    made = draw(device, mesh, 32, by="curvature", tolerance=1e-5)
    tags = made.tags()
    assert (tags[points[:, 0] < 0.3] == 0).all()
    assert (tags[points[:, 0] > 0.7] > 1).all()


def test_tolerance_is_the_height_of_the_arcs_that_are_left(device):
    mesh = icosphere(1)
    for tolerance in (1e-3, 1e-4):
        made = draw(device, mesh, 64, by="curvature", tolerance=tolerance).welded()
        fine = pn_triangles.refine(device, mesh, segments=64).mesh
        middles = made.positions[made.triangles].mean(axis=1)
        radii = np.linalg.norm(fine.positions, axis=1)
        off = np.abs(np.linalg.norm(middles, axis=1) - 1)
        assert off.max() < 3 * tolerance * mesh.diagonal + np.abs(radii - 1).max()


def test_a_frame_that_needs_more_room_gets_it(device):
    mesh = shaken(icosphere(2))
    prepared = AdaptivePatterns(device, mesh, Params(32, by="distance", near=0.5))
    run(device, prepared, Frame(orbit((0, 0, 0), 500.0)))
    few = prepared.counters()["triangles"]
    run(device, prepared, Frame(orbit((0, 0, 0), 1.2)))
    assert prepared.counters()["triangles"] > 20 * few
    assert prepared.check().passed
    run(device, prepared, Frame(orbit((0, 0, 0), 500.0)))
    assert prepared.counters()["triangles"] == few


def test_chunks_of_triangles_are_joined_to_the_bit(device, monkeypatch):
    mesh = shaken(icosphere(2))
    depths = np.random.default_rng(2).random(mesh.vertex_count) * 4
    whole = draw(device, mesh, 16, depths).result()[0]
    monkeypatch.setattr(scan, "CHUNK_ROWS", 16)
    parts = draw(device, mesh, 16, depths)
    assert parts.check().passed
    assert np.array_equal(parts.result()[0].positions, whole.positions)
    assert np.array_equal(parts.result()[0].triangles, whole.triangles)


def test_without_room_a_frame_writes_nothing(device):
    mesh = icosphere(1)
    prepared = AdaptivePatterns(device, mesh, Params(32, by="distance"))
    assert prepared.overflowed()
    assert device.read(prepared.output[0].counts).tolist() == [0, 0]


def test_lists_of_triangles_are_an_option(device):
    mesh = shaken(icosphere(1))
    depths = np.random.default_rng(1).random(mesh.vertex_count) * 4
    listed, bare = (draw(device, mesh, 16, depths, indices=i) for i in (True, False))
    assert not bare.output
    for one, other in ((listed.result()[0], bare.result()[0]), (listed.welded(), bare.welded())):
        assert np.array_equal(one.triangles, other.triangles)
        assert np.array_equal(one.positions, other.positions)


def test_geomorphing_is_continuous_where_a_level_begins(device):
    mesh = shaken(icosphere(1))
    for depth in (1.0, 2.0, 3.0):
        before, after = (
            draw(device, mesh, 16, np.full(mesh.vertex_count, d), geomorphing=True)
            for d in (depth, depth + 1e-4)
        )
        fine = after.welded()
        assert fine.triangle_count == 4 * before.counters()["triangles"]
        coarse = draw(device, mesh, 16, np.full(mesh.vertex_count, depth), geomorphing=True)
        # every new vertex lies in the middle of an edge that was there
        welded = coarse.welded()
        edges = np.unique(
            np.sort(welded.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), 1), axis=0
        )
        middles = welded.positions[edges].mean(axis=1)
        away, _ = cKDTree(np.concatenate([welded.positions, middles])).query(fine.positions)
        assert away.max() < 1e-4


def test_split_normals_open_creases_and_nothing_else(device):
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0.5], [0, 1, 0]]
    normals = [[0, 0, 1]] * 3 + [[-0.6, 0, 0.8], [0, 0, 1], [0, 0, 1]]
    mesh = TriangleMesh(points, [[0, 1, 2], [3, 4, 5]], normals)
    made = draw(device, mesh, 8, np.full(6, 2.0)).result()[0]
    assert len(np.unique(made.positions + np.float32(0), axis=0)) == 28, "2 * 15 less both ends"


def test_other_values_are_interpolated(device):
    sheet = plane(2)
    mesh = TriangleMesh(sheet.positions, sheet.triangles, uvs=sheet.positions[:, :2])
    made = draw(device, mesh, 8, np.array([0, 1, 2, 3, 1, 2, 0, 3, 1.5]), surface="flat")
    for refined in (made.result()[0], made.welded()):
        np.testing.assert_allclose(refined.uvs, refined.positions[:, :2], atol=1e-6)


def test_users_call_it_by_name(device):
    mesh = icosphere(1)
    result = refine_mesh(device, mesh, method="adaptive_patterns", segments=16, tolerance=1e-3)
    assert np.array_equal(result.mesh.positions[result.vertex_map], mesh.positions), (
        "corners stay where they are, to the bit"
    )
    points, faces = refine(
        mesh, method="adaptive_patterns", segments=8, by="given",
        depths=np.zeros(mesh.vertex_count), device=device,
    )  # fmt: skip
    assert (len(points), len(faces)) == (mesh.vertex_count, mesh.triangle_count)


def test_depths_come_from_a_file(device, tmp_path):
    mesh, file = icosphere(1), tmp_path / "depths.npy"
    np.save(file, np.ones(mesh.vertex_count))
    options = {"method": "adaptive_patterns", "segments": 8, "by": "given", "device": device}
    assert len(refine(mesh, depths=str(file), **options)[1]) == 4 * mesh.triangle_count
    with pytest.raises(ValueError, match=r"depths: expected a \.npy file, got"):
        refine(mesh, depths=str(tmp_path / "none.npy"), **options)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"segments": 12}, "segments: expected a power of two up to 128, got 12"),
        ({"segments": 256}, "segments: expected a power of two up to 128, got 256"),
        ({"by": "size"}, "by: expected one of curvature, distance"),
        ({"by": "given"}, "depths: expected one per vertex with by='given', got none"),
        ({"depths": np.zeros(12)}, "depths: expected one per vertex with by='given', got some"),
        ({"by": "given", "depths": np.zeros(3)}, r"depths: expected finite \(12,\), got shape"),
    ],
)
def test_bad_options_are_refused_by_name(device, options, text):
    with pytest.raises(ValueError, match=text):
        refine(icosphere(0), method="adaptive_patterns", device=device, **options)
