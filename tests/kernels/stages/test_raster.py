import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.datasets_gen.triangles import icosphere
from lodbench.kernels.opencl.device import Device
from lodbench.kernels.stages import raster as raster_module
from lodbench.kernels.stages.camera import look_at, to_screen
from lodbench.kernels.stages.raster import EMPTY_ID, Raster
from lodbench.kernels.stages.raster_reference import draw
from lodbench.kernels.stages.shading import Shading
from lodbench.kernels.system import DeviceSurface, Frame, Timeline, View

QUAD = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)


def pixel_view(width, height):
    """World x, y are pixels with y down, z is depth 0..1."""
    matrix = np.diag([2 / width, -2 / height, 2.0, 1.0])
    matrix[:3, 3] = -1, 1, -1
    return View(np.zeros(3), matrix, width, height)


def upload(device, positions, triangles, normals=None, **more):
    positions = np.asarray(positions, np.float32).reshape(-1, 3)
    triangles = np.asarray(triangles, np.uint32).reshape(-1, 3)
    return DeviceSurface(
        device.upload("positions", positions),
        None if normals is None else device.upload("normals", np.asarray(normals, np.float32)),
        device.upload("triangles", triangles),
        more.pop("vertex_count", len(positions)),
        more.pop("triangle_count", len(triangles)),
        **more,
    )


def drawn(device, surface, view, shading=None, **options):
    raster = Raster(device, [surface], view.width, view.height, shading, **options)
    raster([surface], Frame(view), Timeline())
    return raster


def assert_equals_reference(device, positions, triangles, view, **options):
    positions, triangles = np.asarray(positions, np.float32), np.asarray(triangles, np.uint32)
    surface = upload(device, positions, triangles)
    shading = Shading(cull=options.pop("cull", False))
    depths, ids, counts = draw(
        positions, triangles, to_screen(view), view.width, view.height, shading.cull
    )
    seen_depths, seen_ids = drawn(device, surface, view, shading, **options).keys()
    np.testing.assert_array_equal(seen_ids, ids)
    np.testing.assert_array_equal(seen_depths, depths)
    counted = drawn(device, surface, view, shading, count=True, **options).coverage()
    np.testing.assert_array_equal(counted, counts)
    return depths, ids, counts


def soup(seed, count, width, height, size):
    """Triangles of about `size` pixels anywhere in and around the image."""
    rng = np.random.default_rng(seed)
    middle = rng.uniform((-4, -4, 0.2), (width + 4, height + 4, 0.8), (count, 1, 3))
    spread = rng.normal(0, 1, (count, 3, 3)) * (size, size, 0.1)
    return (middle + spread).reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)


@pytest.mark.parametrize("size", [0.3, 1.5, 4, 12, 60])
@pytest.mark.parametrize("count", [1, 7, 8, 9, 150])
def test_raster_equals_reference_on_random_triangles(device, size, count):
    view = pixel_view(70, 41)  # neither side a multiple of a tile or of eight
    assert_equals_reference(device, *soup(count, count, 70, 41, size), view)


def test_raster_equals_reference_on_triangles_across_tiles(device):
    view = pixel_view(150, 140)
    assert_equals_reference(device, *soup(5, 60, 150, 140, 30), view)


def test_raster_equals_reference_with_culling(device):
    positions, triangles = soup(3, 200, 40, 40, 3)
    _, _, kept = assert_equals_reference(
        device, positions, triangles, pixel_view(40, 40), cull=True
    )
    *_, other = assert_equals_reference(
        device, positions, triangles[:, ::-1], pixel_view(40, 40), cull=True
    )
    *_, both = assert_equals_reference(device, positions, triangles, pixel_view(40, 40))
    np.testing.assert_array_equal(kept + other, both)


@pytest.mark.parametrize("near", [1e-3, 0.5])
def test_raster_clips_what_crosses_the_near_plane_like_the_reference(device, near):
    rng = np.random.default_rng(11)
    positions = rng.normal(0, 2, (90, 3))  # the eye is in their midst: behind it, across, in front
    view = look_at((0, 0, 0.1), (0, 0, -1), size=(48, 40), near=near, far=100)
    _, ids, _ = assert_equals_reference(device, positions, np.arange(90).reshape(-1, 3), view)
    assert (ids != EMPTY_ID).mean() > 0.5


def test_raster_clips_at_the_guard_band_like_the_reference(device):
    # corners some 10^5 pixels away, where 32-bit edges would overflow
    positions = np.array([[-1e5, -2e5, 0.5], [3e5, 10, 0.5], [20, 4e5, 0.25], [7, 9, 0.1]])
    view = pixel_view(64, 64)
    triangles = [[0, 1, 2], [0, 1, 3], [1, 2, 3]]
    _, ids, _ = assert_equals_reference(device, positions, triangles, view)
    assert (ids != EMPTY_ID).any()


@pytest.mark.parametrize("swap", [False, True])
def test_triangle_with_all_corners_beyond_opposite_sides_of_the_guard_band_is_seen(device, swap):
    # none of the sides has all three corners behind it
    corners = np.array([[10, -1e5, 0.5], [60, -1e5, 0.5], [32, 1e5, 0.25]])
    positions = np.concatenate([corners, corners * (1, -1, 1)])
    positions = positions[:, [1, 0, 2]] if swap else positions
    for triangle in ([0, 1, 2], [3, 4, 5]):
        _, ids, _ = assert_equals_reference(device, positions, [triangle], pixel_view(64, 64))
        assert (ids != EMPTY_ID).any()


def test_raster_draws_nothing_behind_the_eye_beyond_far_or_beside(device):
    view = look_at((0, 0, 0), (0, 0, -1), size=(32, 32), near=0.1, far=10)
    triangle = np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0]])
    for move in ((0, 0, 5), (0, 0, -20), (0, 0, -0.05), (50, 0, -5), (0, -50, -5)):
        _, ids, _ = assert_equals_reference(device, triangle + move, [[0, 1, 2]], view)
        assert (ids == EMPTY_ID).all()


def test_raster_skips_degenerate_triangles(device):
    positions = [[1, 1, 0.5], [9, 1, 0.5], [5, 1, 0.5], [1, 1, 0.5], [9, 9, 0.5]]
    triangles = [[0, 1, 2], [0, 0, 4], [0, 3, 1], [0, 1, 4]]
    _, ids, counts = assert_equals_reference(device, positions, triangles, pixel_view(12, 12))
    assert set(np.unique(ids)) == {3, EMPTY_ID}
    assert counts.max() == 1


def test_raster_owns_top_and_left_edges_only(device):
    # edges through pixel centres: rows and columns 1 to 3 belong to the square, 4 to its neighbours
    square = [[1.5, 1.5, 0.5], [4.5, 1.5, 0.5], [4.5, 4.5, 0.5], [1.5, 4.5, 0.5]]
    _, _, counts = assert_equals_reference(device, square, QUAD, pixel_view(8, 8))
    expected = np.zeros((8, 8), int)
    expected[1:4, 1:4] = 1
    np.testing.assert_array_equal(counts, expected)


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.tuples(st.floats(-3, 40), st.floats(-3, 40)), min_size=3, max_size=24),
    st.integers(1, 37),
    st.integers(1, 37),
)
def test_raster_equals_reference_on_any_fan(device, corners, width, height):
    positions = np.array([(x, y, 0.25 + 0.02 * k) for k, (x, y) in enumerate(corners)])
    triangles = [[0, k - 1, k] for k in range(2, len(corners))]
    assert_equals_reference(device, positions, triangles, pixel_view(width, height))


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 60), st.floats(0.05, 3))
def test_raster_covers_a_grid_exactly_once(device, seed, cells, jitter):
    # an image that lies inside a jittered grid: neither hole nor double hit along its edges
    rng = np.random.default_rng(seed)
    side = np.linspace(-8, 40, cells + 1)
    y, x = np.meshgrid(side, side, indexing="ij")
    shift = rng.uniform(-0.3, 0.3, (2, cells + 1, cells + 1)) * min(jitter, 1) * (48 / cells)
    inner = np.zeros((cells + 1, cells + 1))
    inner[1:-1, 1:-1] = 1
    positions = np.stack([x + shift[0] * inner, y + shift[1] * inner, 0 * x + 0.5], -1).reshape(
        -1, 3
    )
    a = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    b, c, d = a + 1, a + cells + 1, a + cells + 2
    # quads are cut along either diagonal
    flip = rng.random(len(a)) < 0.5
    first = np.where(flip[:, None], np.stack([a, b, d], 1), np.stack([a, b, c], 1))
    second = np.where(flip[:, None], np.stack([a, d, c], 1), np.stack([b, d, c], 1))
    triangles = np.concatenate([first, second])
    coverage = drawn(device, upload(device, positions, triangles), pixel_view(32, 32), count=True)
    p, q = (positions[triangles[:, k], :2] - positions[triangles[:, 0], :2] for k in (1, 2))
    if (p[:, 0] * q[:, 1] > p[:, 1] * q[:, 0]).all():  # no quad folded over by its jitter
        np.testing.assert_array_equal(coverage.coverage(), 1)


@pytest.mark.parametrize("levels", [0, 2, 5])
def test_raster_covers_each_pixel_once_inside_a_closed_mesh(device, levels):
    mesh = icosphere(levels)
    surface = upload(device, mesh.positions, mesh.triangles)
    for target in ((1, 0.2, 0.1), (-0.3, -1, 0.4), (0.1, 0.2, 1)):
        view = look_at((0.1, -0.05, 0.2), target, fov_y=80, size=(200, 130), near=1e-3, far=10)
        np.testing.assert_array_equal(drawn(device, surface, view, count=True).coverage(), 1)


def test_raster_gives_equal_depths_to_the_lower_id(device):
    positions, triangles = soup(8, 40, 60, 60, 8)
    twice = np.concatenate([triangles, triangles])
    surface = upload(device, positions, twice)
    _, ids = drawn(device, surface, pixel_view(60, 60)).keys()
    assert ids[ids != EMPTY_ID].max() < 40
    backwards = upload(device, positions, np.concatenate([triangles, triangles])[::-1])
    _, reverse = drawn(device, backwards, pixel_view(60, 60)).keys()
    assert reverse[reverse != EMPTY_ID].max() < 40


def pictures(device, **options):
    rng = np.random.default_rng(2)
    small, faces = soup(21, 3000, 200, 150, 1.5)
    large, more = soup(22, 60, 200, 150, 60)
    positions = np.concatenate([small, large])
    normals = rng.normal(size=positions.shape)
    surface = upload(device, positions, np.concatenate([faces, more + len(small)]), normals)
    raster = drawn(device, surface, pixel_view(200, 150), Shading(wireframe=True), **options)
    return raster.image(), *raster.keys()


def test_raster_gives_the_same_bits_for_any_maps_groups_and_sharing(device):
    expected = pictures(device)
    # Intel's driver loses parts of clipped triangles where it puts 16 items into one loop; no raster is launched so
    wide = 7 if device.facts.platform.startswith("Intel") else 64
    for options in (
        {"maps": 1},
        {"maps": 2},
        {"maps": 5},
        {"maps": 3, "local": 7},
        {"local": wide},
        {"shared": True},
        {"shared": True, "local": min(wide, 16)},
    ):
        for have, want in zip(pictures(device, **options), expected, strict=True):
            np.testing.assert_array_equal(have, want, err_msg=str(options))


@pytest.mark.parametrize("options", [{"local_size": 1}, {"local_size": 17}, {"one_core": True}])
def test_raster_gives_the_same_bits_on_a_device_opened_otherwise(device, options):
    other = Device.open(**options)
    for have, want in zip(pictures(other), pictures(device), strict=True):
        np.testing.assert_array_equal(have, want)


def test_raster_draws_large_triangles_that_find_the_queue_full(device, monkeypatch):
    monkeypatch.setattr(raster_module, "LARGE_CAPACITY", 2)
    monkeypatch.setattr(raster_module, "LARGE_PIXELS", 16)
    assert_equals_reference(device, *soup(9, 40, 70, 70, 25), pixel_view(70, 70))


def test_raster_draws_an_image_of_one_pixel(device):
    triangle = [[-1, -1, 0.5], [3, -1, 0.5], [-1, 3, 0.5]]
    _, ids, _ = assert_equals_reference(device, triangle, [[0, 1, 2]], pixel_view(1, 1))
    assert ids[0, 0] == 0


def test_raster_draws_an_image_of_8192_pixels_a_side(device):
    side = 8192
    quad = np.array([[0, 0, 0.5], [side, 0, 0.5], [side, side, 0.5], [0, side, 0.5]])
    tiny = np.array([[8190.2, 8191.1, 0.25], [8191.9, 8191.1, 0.25], [8191.2, 8191.9, 0.25]])
    triangles = np.concatenate([QUAD, [[4, 5, 6]]])
    surface = upload(device, np.concatenate([quad, tiny]), triangles)
    raster = drawn(device, surface, pixel_view(side, side), Shading(smooth=False), maps=1)
    depths, ids = raster.keys()
    assert (ids == 2).sum() == 1 and ids[8191, 8191] == 2
    assert ((ids == 0) | (ids == 1) | (ids == 2)).all()
    np.testing.assert_array_equal(depths[ids != 2], np.float32(0.5))
    assert raster.image().shape == (side, side, 3)


def test_raster_draws_live_triangles_only(device):
    positions, triangles = soup(4, 30, 40, 40, 5)
    counts = device.upload("counts", np.array([len(positions), 12], np.uint32))
    surface = upload(device, positions, triangles, counts=counts)
    _, ids = drawn(device, surface, pixel_view(40, 40)).keys()
    _, expected = drawn(
        device, upload(device, positions, triangles[:12]), pixel_view(40, 40)
    ).keys()
    np.testing.assert_array_equal(ids, expected)


@pytest.mark.parametrize("pattern", [1, 3, 8, 20])
def test_raster_draws_instances_like_one_list(device, pattern):
    positions, _ = soup(6, 7 * pattern, 40, 40, 5)
    one = np.arange(3 * pattern).reshape(-1, 3)
    whole = np.concatenate([one + 3 * pattern * k for k in range(7)])
    surface = upload(
        device,
        positions,
        one,
        triangle_count=7 * pattern,
        instances=7,
        instance_vertices=3 * pattern,
    )
    have = drawn(device, surface, pixel_view(40, 40), Shading(smooth=False))
    want = drawn(
        device, upload(device, positions, whole), pixel_view(40, 40), Shading(smooth=False)
    )
    np.testing.assert_array_equal(have.keys()[1], want.keys()[1])
    np.testing.assert_array_equal(have.image(), want.image())


def test_raster_draws_an_empty_surface_as_background(device):
    raster = drawn(device, upload(device, [], []), pixel_view(20, 10))
    assert (raster.keys()[1] == EMPTY_ID).all()
    image = raster.image()
    assert image.shape == (10, 20, 3)
    np.testing.assert_array_equal(image, image[:, :1].repeat(20, 1))


def test_raster_neither_allocates_nor_keeps_anything_from_frame_to_frame(device):
    positions, triangles = soup(14, 500, 90, 90, 4)
    surface = upload(device, positions, triangles)
    raster = drawn(device, surface, pixel_view(90, 90))
    first, used = raster.image(), device.used_bytes
    raster(
        [upload(device, np.add(positions, (40, 40, 0)), triangles)],
        Frame(pixel_view(90, 90)),
        Timeline(),
    )
    moved = raster.image()
    assert (moved != first).any()
    for _ in range(3):
        raster([surface], Frame(pixel_view(90, 90)), Timeline())
    np.testing.assert_array_equal(raster.image(), first)
    assert device.used_bytes <= used


@pytest.mark.parametrize("instances", [1, 3])
def test_raster_draws_surfaces_of_other_sizes_as_one_made_for_them(device, instances):
    view = pixel_view(90, 90)

    def surface(seed, count):
        points, triangles = soup(seed, count, 90, 90, 30)
        own = np.concatenate([points + 5 * k for k in range(instances)])
        return upload(
            device, own, triangles, np.tile((0, 0, 1), (len(own), 1)), instances=instances,
            triangle_count=instances * len(triangles), instance_vertices=len(points),
        )  # fmt: skip

    large, small = surface(1, 40), surface(2, 7)
    expected = {id(s): drawn(device, s, view).image() for s in (large, small)}
    raster = Raster(device, [large], 90, 90)
    used = device.used_bytes
    for one in (small, large, small):
        raster([one], Frame(view), Timeline())
        np.testing.assert_array_equal(raster.image(), expected[id(one)])
    assert device.used_bytes == used


def several(device, seeds, **options):
    """Surfaces that overlap, and all of them as one."""
    parts = [soup(seed, 60, 90, 90, 30) for seed in seeds]
    first = np.cumsum([0, *(len(points) for points, _ in parts)])
    whole = (
        np.concatenate([points for points, _ in parts]),
        np.concatenate([faces + at for (_, faces), at in zip(parts, first, strict=False)]),
    )
    return [upload(device, *part) for part in parts], upload(device, *whole, **options)


@pytest.mark.parametrize("shading", [Shading(), Shading(by_triangle=True), Shading(wireframe=True)])
@pytest.mark.parametrize("shared", [False, True])
def test_raster_draws_several_surfaces_as_the_one_that_they_make(device, shading, shared):
    surfaces, whole = several(device, (1, 2, 3))
    view = pixel_view(90, 90)
    raster = Raster(device, surfaces, 90, 90, shading, shared=shared)
    expected = Raster(device, [whole], 90, 90, shading, shared=shared)
    for one in (raster, expected):
        one(surfaces if one is raster else [whole], Frame(view), Timeline())
    np.testing.assert_array_equal(raster.keys()[1], expected.keys()[1])
    np.testing.assert_array_equal(raster.keys()[0], expected.keys()[0])
    np.testing.assert_array_equal(raster.image(), expected.image())


def test_raster_takes_as_many_surfaces_as_each_frame_has(device):
    surfaces, _ = several(device, (1, 2, 3))
    frame = Frame(pixel_view(90, 90))

    def fresh(count):
        own = Raster(device, surfaces[:count], 90, 90)
        own(surfaces[:count], frame, Timeline())
        return own.image()

    raster = Raster(device, surfaces[:1], 90, 90)
    for count in (1, 3, 2, 1, 3):
        raster(surfaces[:count], frame, Timeline())
        np.testing.assert_array_equal(raster.image(), fresh(count))


def test_raster_of_several_surfaces_mixes_instances_and_live_counts(device):
    points, triangles = soup(5, 20, 90, 90, 30)
    copies = np.concatenate([points + 9 * k for k in range(3)])
    instanced = upload(
        device, copies, triangles, instances=3, triangle_count=60, instance_vertices=len(points)
    )
    live = device.upload("counts", np.array([len(points), 7], np.uint32))
    some = upload(device, points[:, [1, 0, 2]], triangles, counts=live)
    pair = [instanced, some]
    view = pixel_view(90, 90)
    raster = Raster(device, pair, 90, 90, Shading(smooth=False))
    raster(pair, Frame(view), Timeline())
    faces = np.concatenate(
        [*(triangles + k * len(points) for k in range(3)), triangles[:7] + 3 * len(points)]
    )
    every = upload(device, np.concatenate([copies, points[:, [1, 0, 2]]]), faces)
    expected = drawn(device, every, view, Shading(smooth=False))
    np.testing.assert_array_equal(raster.keys()[1], expected.keys()[1])
    np.testing.assert_array_equal(raster.image(), expected.image())


def test_raster_refuses_no_surface_and_values_for_several(device):
    surfaces, _ = several(device, (1, 2))
    with pytest.raises(ValueError, match="surfaces: expected at least one, got none"):
        Raster(device, [], 90, 90)
    values = Shading(values=np.zeros(60, np.float32), values_of="triangles")
    with pytest.raises(ValueError, match="values: expected one surface to colour, got 2"):
        Raster(device, surfaces, 90, 90, values)


def test_raster_reports_its_stages(device):
    surface = upload(device, *soup(1, 10, 20, 20, 5))
    raster = Raster(device, [surface], 20, 20, view=pixel_view(20, 20))
    timeline = Timeline()
    raster([surface], Frame(), timeline)
    device.wait()
    assert list(timeline.collect().stage_s) == ["vertex_transform", "raster", "fragment"]


def test_raster_refuses_what_it_cannot_draw(device):
    surface = upload(device, *soup(1, 4, 20, 20, 5))
    with pytest.raises(ValueError, match="width: expected 1 to 16384, got 0"):
        Raster(device, [surface], 0, 10)
    with pytest.raises(ValueError, match="height: expected 1 to 16384, got 20000"):
        Raster(device, [surface], 10, 20000)
    raster = Raster(device, [surface], 20, 20)
    with pytest.raises(ValueError, match="expected a view"):
        raster([surface], Frame(), Timeline())
    with pytest.raises(ValueError, match="expected 20 x 20 pixels, got 30 x 20"):
        raster([surface], Frame(pixel_view(30, 20)), Timeline())
    with pytest.raises(ValueError, match="surface: expected one mesh with no normals, got inst"):
        other = upload(device, *soup(1, 4, 20, 20, 5), instances=2)
        raster([other], Frame(pixel_view(20, 20)), Timeline())
    with pytest.raises(ValueError, match="values: expected 12 of vertices, got 5"):
        Raster(device, [surface], 20, 20, Shading(values=np.zeros(5, np.float32)))
    with pytest.raises(ValueError, match="count=True"):
        raster.coverage()


@pytest.mark.parametrize("large", [8, 1 << 20], ids=["shared by tiles", "by one item"])
def test_centres_on_left_and_top_edges_belong_to_the_triangle(device, monkeypatch, large):
    monkeypatch.setattr(raster_module, "LARGE_PIXELS", large)
    square = [[1.5, 1.5, 0.5], [20.5, 1.5, 0.5], [20.5, 20.5, 0.5], [1.5, 20.5, 0.5]]
    view = pixel_view(24, 24)
    counted = drawn(device, upload(device, square, QUAD), view, count=True).coverage()
    expected = np.zeros((24, 24), int)
    expected[1:20, 1:20] = 1
    np.testing.assert_array_equal(counted, expected)
