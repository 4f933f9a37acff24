import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.measure.quality import topology
from lodbench.kernels import simplify_mesh
from lodbench.kernels.cluster import vertex_average
from lodbench.kernels.cluster.quadric_clustering import Params
from lodbench.kernels.cluster.quadric_clustering.host import prepare
from lodbench.kernels.cluster.quadric_clustering.reference import simplify
from lodbench.kernels.cluster.upload import Upload
from lodbench.kernels.cluster.warp import GUARD, NEAREST, STEPS, density, log2, region_warp
from lodbench.kernels.cluster.warped import function_table, warp_of
from lodbench.kernels.opencl.device import Device
from lodbench.kernels.stages.camera import look_at
from lodbench.kernels.system import run
from tests.kernels.cluster.meshes import cube, flat_lattice, single_triangle, sphere, wavy_sheet

CUBIC = "float warp(const float t, const int axis)\n{\n    return t * (0.2f + t * t);\n}\n"
REGIONS = ((0.9, 0.1, 0.2, 0.2, 6.0), (-0.5, 0.4, 0.0, 0.1, 3.0))
WARPS = {
    "region": {"regions": REGIONS[:1]},
    "regions": {"regions": REGIONS},
    "view": {"view": look_at((1.5, 0.8, 1.7), (0, 0, 0))},
    "ndc": {"view": look_at((1.5, 0.8, 1.7), (0, 0, 0)), "view_depth": "ndc"},
    "inside": {"view": look_at((0.1, 0.2, 0.3), (2, 1, 0))},
    "parallel": {"view": np.diag([0.5, 0.7, 0.6, 1])},
    "function": {"warp": CUBIC},
}
WAYS = {
    "fused": {},
    "separate": {"strategy": "separate"},
    "fixed_point": {"accumulate": "fixed_point"},
}
T = np.linspace(0, 1, STEPS + 1)


def cluster(device, mesh, *cells, **params):
    prepared = prepare(device, mesh, Params(*cells, **params))
    run(device, prepared)
    return prepared


def bytes_of(mesh):
    return mesh.positions.tobytes(), mesh.triangles.tobytes()


spot = st.tuples(st.floats(-1, 2), st.floats(1e-3, 2), st.floats(1, 1000))


@given(regions=st.lists(spot, max_size=4))
def test_region_warp_rises_from_0_to_1_as_fast_as_the_density(regions):
    warped = region_warp(T, regions)
    assert warped[0] == 0
    assert warped[-1] == pytest.approx(1, abs=1e-12)
    assert (np.diff(warped) > 0).all()
    middle, step = T[:-1] + 0.5 / STEPS, 1e-6
    slope = (region_warp(middle + step, regions) - region_warp(middle - step, regions)) / (2 * step)
    found = density(middle, regions)
    assert slope / slope.mean() == pytest.approx(found / found.mean(), rel=1e-3)


def test_weight_is_how_many_times_finer_the_centre_is_than_far_away():
    slope = np.gradient(region_warp(T, [(0.5, 0.03, 8.0)]), T)
    assert slope[STEPS // 2] / slope[5] == pytest.approx(8, rel=1e-2)
    assert np.array_equal(region_warp(T, []), T)
    assert region_warp(T, [(0.3, 0.1, 1.0)]) == pytest.approx(T, abs=1e-15)


def test_cells_hold_even_points_as_the_density_says(device):
    # 64 cells along x of points that are even there: each holds what lies between its planes
    x = np.random.default_rng(0).random(200_000)
    x[:2] = 0, 1
    mesh = TriangleMesh(np.stack([x, x, 0 * x], axis=1), [[0, 1, 2]])
    regions = [(0.3, 0.9, 0, 0.1, 5.0)]
    warp = warp_of(Params(64, regions=regions), mesh)
    places, _ = warp(mesh.positions)
    share = (places[:, 0] - places[:, 0].min()) / np.ptp(places[:, 0])
    counts = np.histogram(share, 64, (0, 1))[0]
    planes = np.interp(np.linspace(0, 1, 65), region_warp(T, [(0.3, 0.1, 5.0)]), T)
    assert counts / len(x) == pytest.approx(np.diff(planes), abs=5 * np.sqrt(0.03 / len(x)))


MESHES = {
    "sphere": sphere(),
    "sheet": wavy_sheet(),
    "flat": flat_lattice(9),
    "triangle": single_triangle(),
    "cube": cube(),
    "far": TriangleMesh(sphere().positions + np.float32(1000), sphere().triangles),
    "large": TriangleMesh(sphere().positions * np.float32(1e30), sphere().triangles),
    "small": TriangleMesh(sphere().positions * np.float32(1e-30), sphere().triangles),
    "point": TriangleMesh(np.full((3, 3), 7.0), [[0, 1, 2]]),
    "line": TriangleMesh([[0, 0, 0], [1, 1, 1], [2, 2, 2]], [[0, 1, 2]]),
    "pair": TriangleMesh(sphere().positions, np.repeat(sphere().triangles, 2, axis=0)),
}


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
@pytest.mark.parametrize("warp", WARPS.values(), ids=WARPS)
def test_kernels_place_vertices_as_numpy_does(device, mesh, warp):
    # bit for bit: whatever is fused or divided otherwise would put vertices into other cells
    made = warp_of(Params(8, **warp), mesh, device)
    upload = Upload(device, mesh, (), made)
    places, stretch = made(mesh.positions)
    assert np.isfinite(places).all()
    assert (stretch > 0).all()
    assert np.array_equal(device.read(upload.placed), places)
    assert np.array_equal(device.read(upload.stretch), stretch)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
@pytest.mark.parametrize("warp", WARPS.values(), ids=WARPS)
def test_warped_clustering_agrees_with_its_reference(device, mesh, warp, way):
    for cells in (7.5, (5, 6, 4)):
        prepared = cluster(device, mesh, cells, **warp, **WAYS[way])
        check = prepared.check()
        assert check.passed, f"{check.what}: {check.value} > {check.tolerance}"
        (found,) = prepared.result()
        assert np.isfinite(found.positions).all()


@pytest.mark.parametrize("warp", WARPS.values(), ids=WARPS)
def test_means_in_warped_cells_agree_with_their_reference(device, warp):
    params = vertex_average.Params(9, **warp)
    prepared = vertex_average.SYSTEM.prepare(device, wavy_sheet(), params)
    run(device, prepared)
    assert prepared.check().passed


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("cells", [6.3, 9])
def test_weight_1_changes_no_byte(device, cells, way):
    for mesh in (sphere(), wavy_sheet(), MESHES["far"], MESHES["small"]):
        regions = [(0.5, 0.5, 0, 0.1, 1.0)]
        even = cluster(device, mesh, cells, **WAYS[way]).result()[0]
        same = cluster(device, mesh, cells, regions=regions, **WAYS[way]).result()[0]
        assert bytes_of(same) == bytes_of(even)


@pytest.mark.parametrize("warp", WARPS.values(), ids=WARPS)
def test_closed_surface_stays_without_open_edges(device, warp):
    (found,) = cluster(device, sphere(40, 60), 12, **warp).result()
    assert found.triangle_count
    assert topology(found)["open_edges"] == 0


@pytest.mark.parametrize("warp", WARPS.values(), ids=WARPS)
def test_no_representative_steps_farther_than_a_cell_is_wide_there(device, warp):
    mesh = wavy_sheet(60)
    prepared = cluster(device, mesh, 10, **warp)
    (found,) = prepared.result()
    reference = simplify(mesh, prepared.params, warp_of(prepared.params, mesh, device))
    steps = reference.grid.points(found.positions).astype(float) - reference.means
    assert (np.linalg.norm(steps / (reference.limits + 1e-4), axis=1) <= 1 + 1e-3).all()
    # those of a parallel projection are alike
    assert warp is WARPS["parallel"] or reference.limits.min() < 0.9 * reference.limits.max()


@pytest.mark.parametrize("warp", WARPS.values(), ids=WARPS)
@pytest.mark.parametrize("duplicates", [False, True])
def test_targets_are_kept_under_a_warp(device, warp, duplicates):
    mesh = wavy_sheet(60)
    result = simplify_mesh(device, mesh, target_count=800, remove_duplicates=duplicates, **warp)
    assert 0.9 * 800 <= result.mesh.triangle_count <= 800
    assert result.counters["target_gap"] == 800 - result.mesh.triangle_count


def test_region_gets_more_of_the_triangles(device):
    mesh = sphere(80, 120)
    corner = (1.0, 0.0, 0.0)
    found = {
        weight: simplify_mesh(
            device, mesh, target_count=1500, regions=[(*corner, 0.3, weight)]
        ).mesh
        for weight in (1, 8)
    }
    inside = {
        weight: (np.linalg.norm(one.positions - corner, axis=1) < 0.3).mean()
        for weight, one in found.items()
    }
    assert inside[8] > 2 * inside[1]


def test_cells_are_finer_near_the_eye(device):
    mesh = flat_lattice(128)
    view = look_at((64, -4, 12), (64, 30, 0))
    (found,) = cluster(device, mesh, 60, view=view).result()
    seen = np.abs(found.positions[:, 0] - 64) < 8
    near = seen & (found.positions[:, 1] < 24)
    far = seen & (found.positions[:, 1] > 80) & (found.positions[:, 1] < 96)
    assert near.sum() > 4 * far.sum() > 0


def test_what_is_not_seen_counts_as_on_the_border(device):
    # a row along the line of sight: two that are seen, one to each side, one behind the eye
    eye = look_at((0, 0, 4), (0, 0, 0), fov_y=60, size=(64, 64))
    seen = [[0.5, 0, 0], [-0.5, 0.2, 2], [0.1, -0.5, 1]]
    hidden = [[30, 0, 0], [-30, 0, 0], [0, 0, 50]]
    mesh = TriangleMesh(np.array([*seen, *hidden]), [[0, 1, 2], [3, 4, 5]])
    warp = warp_of(Params(8, view=eye), mesh)
    places, stretch = warp(mesh.positions)
    # each lies on the border of a band about what is seen, in cells of its own
    least, most = places[:3].min(0), places[:3].max(0)
    band = GUARD * (most - least)
    assert places[3, 0] == pytest.approx(most[0] + band[0], rel=1e-3)
    assert places[4, 0] == pytest.approx(least[0] - band[0], rel=1e-3)
    assert places[5, 2] == pytest.approx(least[2] - band[2], rel=1e-3)
    assert (stretch[5] == np.float32(NEAREST)).all()
    assert (stretch[:3] > 0.4).all()


def test_logarithm_rises_without_a_step_and_is_nearly_one():
    w = np.geomspace(1e-6, 1e6, 100_000).astype(np.float32)
    found = log2(w)
    assert (np.diff(found) >= 0).all()
    assert found == pytest.approx(np.log2(w.astype(float)), abs=3e-3)
    assert np.array_equal(log2(np.float32([0.25, 1, 2, 1024])), np.float32([-2, 0, 1, 10]))


def test_nothing_seen_leaves_hardly_anything(device):
    away = look_at((0, 0, 4), (0, 0, 8))
    (found,) = cluster(device, sphere(), 20, view=away).result()
    assert found.triangle_count < sphere().triangle_count
    assert np.isfinite(found.positions).all()


@pytest.mark.parametrize("warp", ["regions", "view"])
def test_regions_and_views_are_where_the_world_has_them(device, warp):
    # a mesh about an origin, and the same one without
    offset = np.array([512.0, -256.0, 64.0])
    here = simplify_mesh(device, sphere(20, 30), cells=9, **WARPS[warp]).mesh
    moved = {
        "regions": {"regions": [(x + 512, y - 256, z + 64, r, w) for x, y, z, r, w in REGIONS]},
        "view": {"view": look_at(np.array((1.5, 0.8, 1.7)) + offset, offset)},
    }
    mesh = TriangleMesh(sphere(20, 30).positions, sphere().triangles[:0], origin=None)
    mesh = TriangleMesh(mesh.positions, sphere(20, 30).triangles, origin=offset)
    there = simplify_mesh(device, mesh, cells=9, **moved[warp]).mesh
    assert there.origin == pytest.approx(offset)
    assert np.array_equal(there.triangles, here.triangles)
    assert there.positions == pytest.approx(here.positions, abs=1e-4)


@pytest.mark.parametrize("warp", WARPS.values(), ids=WARPS)
def test_warped_frames_have_the_same_bytes_for_any_work_group_and_run(device, warp):
    first = cluster(device, wavy_sheet(), 11, **warp)
    expected = bytes_of(first.result()[0])
    run(device, first)
    assert bytes_of(first.result()[0]) == expected
    for options in ({"local_size": 1}, {"one_core": True}):
        other = cluster(Device.open(**options), wavy_sheet(), 11, **warp)
        assert bytes_of(other.result()[0]) == expected


def test_a_box_as_wide_as_float32_is_warped_by_regions_and_refused_by_a_view_beside_it(device):
    widest = TriangleMesh(sphere().positions * np.float32(3.4e38), sphere().triangles)
    prepared = cluster(device, widest, 7, regions=[(3e38, 0, 0, 1e38, 5)])
    assert prepared.check().passed
    assert np.isfinite(prepared.result()[0].positions).all()
    with pytest.raises(ValueError, match="inverted about the mesh"):
        cluster(device, widest, 7, **WARPS["view"])


def test_no_vertices_need_no_warp(device):
    empty = TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int))
    for warp in WARPS.values():
        assert simplify_mesh(device, empty, cells=8, **warp).mesh.triangle_count == 0


def test_function_is_tabulated_from_0_to_1(device):
    table = function_table(
        device, "float warp(const float t, const int axis) { return 3.0f + (axis + 1) * t * t; }"
    )
    assert table == pytest.approx(np.broadcast_to(T**2, (3, STEPS + 1)), abs=1e-5)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("float warp(const float t, const int axis)\n{\n    return t + a;\n}", "line 3: use of"),
        ("float warp(const float t, const int axis) { return t;", "got an error behind it"),
        ("float warp(float4 t) { return t.x; }", "expected float warp"),
        ("float other(float t) { return t; }", "expected float warp.*, got none"),
        ("", "got no text"),
        ("float warp(float t, int a) { return warp(t, a); }", "no recursion"),
        ("float warp(float t, int a) { return 1.0f - t; }", "rises .* along x, got 1 and 0"),
        ("float warp(float t, int a) { return a == 1 ? 0.5f : t; }", "along y, got 0.5 and 0.5"),
        (
            "float warp(float t, int a) { return t + 0.2f * (t > 0.5f && t < 0.6f); }",
            r"got 0\.\d+ after 0\.\d+ at t = 0\.6",
        ),
        ("float warp(float t, int a) { return 1.0f / (t - 0.5f); }", "along x, got inf"),
    ],
)
def test_function_that_is_no_warp_is_refused_in_one_line(device, text, told):
    with pytest.raises(ValueError, match=told) as error:
        simplify_mesh(device, sphere(), cells=8, warp=text)
    assert str(error.value).startswith("warp: ")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"regions": [(0, 0, 0, 1, 0.5)]}, "regions: expected .*weight 1 to 1e6, got"),
        ({"regions": [(0, 0, 0, 0, 2)]}, "radius above 0"),
        ({"regions": [(0, 0, 0, 1)]}, "regions: expected"),
        ({"regions": [(0, 0, np.inf, 1, 2)]}, "regions: expected a finite number"),
        ({"regions": 5}, "regions: expected"),
        ({"regions": [("a", 0, 0, 1, 2)]}, "regions: expected"),
        ({"view": "front"}, "view: expected a View"),
        ({"view": np.eye(3)}, r"view: expected .* \(3, 3\)"),
        ({"view": np.full((4, 4), np.nan)}, "view: .*NaN"),
        ({"view": np.zeros((4, 4))}, "view: expected a world_to_clip that can be inverted"),
        ({"view": np.eye(4), "warp": CUBIC}, "expected one of them, got view and warp"),
        ({"warp": 3}, "warp: expected text"),
    ],
)
def test_options_that_make_no_warp_are_refused_in_one_line(device, options, told):
    with pytest.raises((ValueError, TypeError), match=told) as error:
        simplify_mesh(device, sphere(), cells=8, **options)
    assert "\n" not in str(error.value)


def test_params_of_a_warp_are_plain_numbers():
    view = look_at((1, 2, 3), (0, 0, 0))
    assert (
        Params(view=view) == Params(view=view.world_to_clip) == Params(view=Params(view=view).view)
    )
    rows = np.array([[0, 0, 0, 1, 2.0]])
    assert Params(regions=rows).regions == ((0.0, 0.0, 0.0, 1.0, 2.0),)
    assert Params(view=np.eye(4)).view[0] == (1.0, 0.0, 0.0, 0.0)
