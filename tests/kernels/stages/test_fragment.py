import numpy as np
import pytest

from lodbench.kernels.opencl.device import Device
from lodbench.kernels.stages.camera import look_at
from lodbench.kernels.stages.raster import EMPTY_ID, Raster
from lodbench.kernels.stages.shading import Shading, lights
from lodbench.kernels.system import DeviceSurface, Frame, Timeline
from tests.tolerances import SHADE_LEVELS

TRIANGLE = np.array([[-1.4, -1.1, -0.4], [1.5, -0.9, 0.5], [0.1, 1.6, 0.1]], np.float32)
VIEW = look_at((0.3, 0.2, 3), (0, 0, 0), size=(90, 70), near=0.5, far=9)


def drawn(device, shading, positions=TRIANGLE, triangles=((0, 1, 2),), normals=None, view=VIEW):
    positions, triangles = np.asarray(positions, np.float32), np.asarray(triangles, np.uint32)
    surface = DeviceSurface(
        device.upload("positions", positions),
        None if normals is None else device.upload("normals", np.asarray(normals, np.float32)),
        device.upload("triangles", triangles),
        len(positions),
        len(triangles),
    )
    raster = Raster(device, [surface], view.width, view.height, shading, view=view)
    raster([surface], Frame(), Timeline())
    return raster.image().astype(int), raster.keys()[1]


def weights(view, corners):
    """(height, width, 3) weights of a triangle's corners where each pixel's ray meets its plane, float64."""
    x = (np.arange(view.width) + 0.5) / view.width * 2 - 1
    y = 1 - (np.arange(view.height) + 0.5) / view.height * 2
    m = view.world_to_clip
    rows = np.c_[corners.astype(float), np.ones(3)] @ m.T
    inverse = np.linalg.inv(rows[:, [0, 1, 3]])  # Olano & Greer 1997, equation 5
    pixel = np.stack(np.broadcast_arrays(x[None], y[:, None], 1.0), -1)
    w = pixel @ inverse
    return w / w.sum(-1, keepdims=True)


def shade(normals, colour, view):
    """The lit colour of unit normals, levels 0..255, float64."""
    light = {name: np.array(value) for name, value in lights(view).items()}
    key, fill, sky, half = (light[k] for k in ("key_light", "fill_light", "sky_light", "highlight"))
    lit = (
        np.maximum(normals @ key[:3], 0) * key[3]
        + np.maximum(normals @ fill[:3], 0) * fill[3]
        + (normals @ sky[:3] * 0.33 + 0.67) * sky[3]
    )
    shine = np.maximum(normals @ half[:3], 0) ** 32 * half[3]
    linear = np.asarray(colour) * lit[..., None] + shine[..., None]
    return np.minimum(np.sqrt(np.maximum(linear, 0)) * 255, 255)


def normalised(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def test_fragment_shades_interpolated_normals_as_the_formula_says(device):
    rng = np.random.default_rng(1)
    normals = normalised(rng.normal(size=(3, 3)) * 0.4 + (0, 0, 1))
    image, ids = drawn(device, Shading(), normals=normals)
    expected = shade(normalised(weights(VIEW, TRIANGLE) @ normals), Shading().surface, VIEW)
    inside = ids != EMPTY_ID
    assert inside.sum() > 1000
    assert np.abs(image - expected)[inside].max() <= SHADE_LEVELS


@pytest.mark.parametrize("order", [(0, 1, 2), (0, 2, 1)])
def test_fragment_lights_both_sides_alike(device, order):
    # a facet and its mirror image in winding look the same: the side that is seen is the one that is lit
    image, ids = drawn(device, Shading(smooth=False), triangles=(order,))
    normal = normalised(np.cross(TRIANGLE[1] - TRIANGLE[0], TRIANGLE[2] - TRIANGLE[0]))
    expected = shade(normal[None], Shading().surface, VIEW)[0]
    assert np.abs(image - expected)[ids != EMPTY_ID].max() <= SHADE_LEVELS
    flipped, _ = drawn(
        device, Shading(), triangles=(order,), normals=[normal if order[1] == 1 else -normal] * 3
    )
    assert np.abs(flipped - image).max() <= 1


def test_fragment_shades_a_triangle_whose_corner_is_behind_the_eye(device):
    view = look_at((0, 0, 0), (0, 0, -1), size=(80, 60), near=0.1, far=50)
    corners = np.array([[-3, -1, -6], [0.2, -1, 4], [4, -1.2, -5]], np.float32)
    normals = normalised(np.array([[0.3, 1, 0.1], [-0.5, 1, 0.2], [0, 1, -0.6]]))
    image, ids = drawn(device, Shading(), corners, normals=normals, view=view)
    expected = shade(normalised(weights(view, corners) @ normals), Shading().surface, view)
    inside = ids != EMPTY_ID
    assert inside.sum() > 500
    assert np.abs(image - expected)[inside].max() <= SHADE_LEVELS


def test_fragment_maps_values_of_vertices_and_of_triangles(device):
    ramp = np.linspace(0, 1, 256, dtype=np.float32)[:, None] * np.array((1, 0.5, 0.25), np.float32)
    values = np.array([0, 1, 0.5], np.float32)
    shading = Shading(smooth=False, values=values, colour_map=ramp)
    image, ids = drawn(device, shading)
    inside = ids != EMPTY_ID
    normal = normalised(np.cross(TRIANGLE[1] - TRIANGLE[0], TRIANGLE[2] - TRIANGLE[0]))
    value = np.rint(np.clip(weights(VIEW, TRIANGLE) @ values, 0, 1) * 255) / 255
    expected = shade(
        np.broadcast_to(normal, (*value.shape, 3)), value[..., None] * (1, 0.5, 0.25), VIEW
    )
    # half a step of the table more or less, where the root is not steep
    bright = inside & (value > 0.1)
    assert np.abs(image - expected)[bright].max() <= SHADE_LEVELS + 1
    one = Shading(smooth=False, values=values[1:2], values_of="triangles", colour_map=ramp)
    image, ids = drawn(device, one)
    expected = shade(normal[None], (1, 0.5, 0.25), VIEW)[0]
    assert np.abs(image - expected)[ids != EMPTY_ID].max() <= SHADE_LEVELS


def test_fragment_gives_neighbouring_triangles_different_colours(device):
    rng = np.random.default_rng(0)
    positions = rng.normal(size=(60, 3)) * (1.5, 1.2, 0.5)
    image, ids = drawn(
        device, Shading(smooth=False, by_triangle=True), positions, np.arange(60).reshape(-1, 3)
    )
    colours = {tuple(image[ids == k][0]) for k in np.unique(ids[ids != EMPTY_ID])}
    assert len(colours) == len(np.unique(ids[ids != EMPTY_ID]))


def test_fragment_darkens_edges_by_their_distance_in_pixels(device):
    plain, ids = drawn(device, Shading(smooth=False))
    lined, _ = drawn(device, Shading(smooth=False, wireframe=True, line_width=3))
    inside = ids != EMPTY_ID
    rows = np.c_[TRIANGLE.astype(float), np.ones(3)] @ VIEW.world_to_clip.T
    corners = (rows[:, :2] / rows[:, 3:] * (1, -1) + 1) / 2 * (VIEW.width, VIEW.height)
    pixel = np.stack(np.meshgrid(np.arange(90) + 0.5, np.arange(70) + 0.5), -1)
    nearest = np.full(ids.shape, np.inf)
    for k in range(3):
        a, b = corners[k], corners[(k + 1) % 3]
        along = (b - a) / np.linalg.norm(b - a)
        offset = pixel - a
        nearest = np.minimum(nearest, np.abs(offset @ (-along[1], along[0])))
    # two pixels from the edge nothing changes; within one the line has its full ink of 0.15 of the light
    np.testing.assert_array_equal(
        lined[inside & (nearest > 2.01)], plain[inside & (nearest > 2.01)]
    )
    core = inside & (nearest < 0.98)
    np.testing.assert_allclose(lined[core], plain[core] * np.sqrt(0.15), atol=1)


def test_fragment_draws_the_background_from_top_to_bottom(device):
    shading = Shading(background=((1, 0.25, 0), (0, 0.25, 1)))
    image, ids = drawn(device, shading, triangles=np.zeros((0, 3)))
    assert (ids == EMPTY_ID).all()
    t = (np.arange(VIEW.height) + 0.5) / VIEW.height
    expected = np.stack([np.sqrt(1 - t) * 255, 0 * t + 127.5, np.sqrt(t) * 255], 1)
    assert np.abs(image - expected[:, None]).max() <= 0.51


def test_fragment_falls_back_to_facets_without_normals(device):
    smooth, _ = drawn(device, Shading(smooth=True))
    flat, _ = drawn(device, Shading(smooth=False))
    np.testing.assert_array_equal(smooth, flat)


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_fragment_does_not_depend_on_the_unit_of_length(device, scale):
    normals = normalised(np.add(TRIANGLE, (0, 0, 1)))
    view = look_at(VIEW.eye * scale, (0, 0, 0), size=(90, 70), near=0.5 * scale, far=9 * scale)
    for shading in (Shading(), Shading(smooth=False, wireframe=True)):
        image, _ = drawn(device, shading, TRIANGLE * np.float32(scale), normals=normals, view=view)
        expected, _ = drawn(device, shading, normals=normals)
        far_off = np.abs(image - expected).max(-1) > 2  # rounding may move a pixel across an edge
        assert far_off.mean() < 0.005


def test_fragment_survives_normals_of_no_length(device):
    image, ids = drawn(device, Shading(), normals=np.zeros((3, 3)))
    assert image[ids != EMPTY_ID].std() < 255


def test_fragment_gives_the_same_bits_for_any_group_size(device):
    normals = normalised(np.add(TRIANGLE, (0, 0, 1)))
    expected, _ = drawn(device, Shading(wireframe=True), normals=normals)
    for size in (1, 3, 64):
        image, _ = drawn(Device.open(local_size=size), Shading(wireframe=True), normals=normals)
        np.testing.assert_array_equal(image, expected)
