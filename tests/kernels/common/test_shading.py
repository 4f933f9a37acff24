import numpy as np
import pytest

from lodbench.kernels.stages.raster import EMPTY_KEY
from tests.kernels.common.calling import Caller
from tests.tolerances import ROUNDING32, SHADE_LEVELS

STORE = "vstore8(e.x, 3 * i, out); vstore8(e.y, 3 * i + 1, out); vstore8(e.z, 3 * i + 2, out);"


def caller(device, folder, instanced=0, several=0):
    return Caller(
        device, folder, "common/shading.cl",
        INSTANCED=instanced, SEVERAL=several, SMOOTH=0, STREAMING=0,
    )  # fmt: skip


@pytest.fixture(scope="module")
def call(device, tmp_path_factory):
    return caller(device, tmp_path_factory.mktemp("kernels"))


def lanes(out):
    """What STORE wrote, (n, 3)."""
    return out.reshape(-1, 3, 8).transpose(0, 2, 1).reshape(-1, 3)


def planes(name):
    return f"{{vload8(3 * i, {name}), vload8(3 * i + 1, {name}), vload8(3 * i + 2, {name})}}"


def transposed(rows):
    """Rows (8 n, 3) as `planes` reads them."""
    return rows.astype(np.float32).reshape(-1, 8, 3).transpose(0, 2, 1)


ROWS = np.array([[0, 5, 2, 9, 9, 1, 3, 8], [7, 3, 3, 3, 0, 8, 8, 8], [4, 4, 4, 4, 6, 6, 6, 6]])


@pytest.mark.parametrize("what", ["gather_screen(values, own)", "gather(values, own, 10)"])
def test_eight_corners_are_gathered(call, what):
    rng, screen = np.random.default_rng(0), "screen" in what
    values = rng.integers(-1000, 1000, (10, 4 if screen else 3)).astype(np.int32)
    if screen:
        values[:, 3] = rng.uniform(0.1, 9, 10).astype(np.float32).view(np.int32)
    rows = ROWS
    found = call(
        f"""uint own[8];
    for (int k = 0; k < 8; ++k) own[k] = rows[8 * i + k];
    const planes8 e = {what};
    {STORE}""",
        len(rows),
        {"out": (24 * len(rows), np.float32)},
        values=values if screen else values.astype(np.float32),
        rows=rows.astype(np.uint32),
    )
    expected = values[rows.ravel()][:, [0, 1, -1]].astype(np.float32)
    if screen:
        expected[:, 2] = values[rows.ravel(), 3].view(np.float32)
    np.testing.assert_array_equal(lanes(found["out"]), expected)


def test_vectors_are_subtracted_and_multiplied_lane_by_lane(call):
    a, b = np.random.default_rng(0).normal(size=(2, 32, 3)).astype(np.float32)
    direction = np.float32([0.5, -2, 3])
    found = call(
        f"""const planes8 p = {planes("a")}, q = {planes("b")};
    vstore8(toward(difference(p, q), vload3(0, direction)), i, along);
    vstore8(toward(across(p, q), vload3(0, direction)), i, volume);
    const planes8 e = spread(vload3(0, direction));
    {STORE}""",
        4,
        {"along": (32, np.float32), "volume": (32, np.float32), "out": (96, np.float32)},
        a=transposed(a), b=transposed(b), direction=direction,
    )  # fmt: skip
    a, b = a.astype(float), b.astype(float)
    size = np.abs(direction).sum() * max(np.abs(a).max(), np.abs(b).max()) ** 2
    assert np.abs(found["along"] - (a - b) @ direction).max() <= ROUNDING32 * size
    assert np.abs(found["volume"] - np.cross(a, b) @ direction).max() <= 2 * ROUNDING32 * size
    np.testing.assert_array_equal(lanes(found["out"]), np.tile(direction, (32, 1)))


@pytest.mark.parametrize("power", [-120, -60, 0, 60, 120])
def test_facet_has_a_normal_whatever_its_size(call, power):
    a, b = np.random.default_rng(0).uniform(-1, 1, (2, 32, 3))
    found = call(
        f"const planes8 e = facet_normal((planes8){planes('a')}, (planes8){planes('b')}); {STORE}",
        4,
        {"out": (96, np.float32)},
        a=transposed(np.ldexp(a, power)),
        b=transposed(np.ldexp(b, power)),
    )
    found = lanes(found["out"]).astype(float)
    expected = np.cross(a, b)
    length = np.linalg.norm(found, axis=1, keepdims=True)
    assert np.isfinite(found).all() and (length > 0).all()
    parallel = np.linalg.norm(expected, axis=1, keepdims=True)
    error = np.abs(found / length - expected / parallel)
    assert (error * parallel <= ROUNDING32).all(), (
        "roundings weigh more where edges are nearly parallel"
    )


def test_pixel_is_the_origin_of_corners_seen_from_it(call):
    rng = np.random.default_rng(0)
    points, m = rng.normal(size=(32, 3)).astype(np.float32), rng.normal(size=16).astype(np.float32)
    x = rng.normal(size=32).astype(np.float32)
    found = call(
        f"""const planes8 p = {planes("points")};
    const planes8 e = seen_from(p, vload16(0, m), vload8(i, x), 0.75f);
    {STORE}""",
        4,
        {"out": (96, np.float32)},
        points=transposed(points), m=m, x=x,
    )  # fmt: skip
    rows = m.reshape(4, 4).astype(float)
    clip = points @ rows[:, :3].T + rows[:, 3]
    expected = np.stack(
        [clip[:, 0] - x * clip[:, 3], clip[:, 1] - 0.75 * clip[:, 3], clip[:, 3]], 1
    )
    assert np.abs(lanes(found["out"]) - expected).max() <= ROUNDING32 * np.abs(expected).max()


def test_edge_is_as_far_as_its_line_lies_from_the_pixel(call):
    rng = np.random.default_rng(0)
    a, b = rng.normal(0, 2000, (2, 32, 2))  # sub-pixels from the pixel's centre
    w = rng.uniform(0.5, 3, (2, 32, 1))
    found = call(
        f"""const planes8 p = {planes("a")}, q = {planes("b")};
    vstore8(fabs(across(p, q).z) * edge_inverse(p, q), i, out);""",
        4,
        {"out": (32, np.float32)},
        a=transposed(np.hstack([a * w[0], w[0]])),
        b=transposed(np.hstack([b * w[1], w[1]])),
    )
    cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    expected = np.abs(cross) / np.linalg.norm(a - b, axis=1) / 256
    assert np.abs(found["out"] - expected).max() <= ROUNDING32 * expected.max() * 10


def test_colours_become_bytes_by_a_square_root_and_are_opaque(call):
    linear = np.random.default_rng(0).uniform(-0.2, 1.2, (32, 3))
    linear[:3] = [[0], [1], [0.25]]
    found = call(
        f"const planes8 e = {planes('linear')}; vstore8(pixel_colour(e), i, out);",
        4,
        {"out": (32, np.uint32)},
        linear=transposed(linear),
    )["out"]
    assert found[:3].tolist() == [0xFF000000, 0xFFFFFFFF, 0xFF808080]
    levels = found.view(np.uint8).reshape(-1, 4)
    assert (levels[:, 3] == 255).all()
    assert np.abs(levels[:, :3] - 255 * np.sqrt(np.clip(linear, 0, 1))).max() <= SHADE_LEVELS


def test_scattered_colours_differ_and_are_neither_black_nor_white(call):
    found = call(
        f"const planes8 e = scattered_colour(vload8(i, ids)); {STORE}",
        128,
        {"out": (3 * 1024, np.float32)},
        ids=np.arange(1024, dtype=np.uint32),
    )
    colours = lanes(found["out"])
    assert len(np.unique(colours, axis=0)) > 1020
    assert 0.15 <= colours.min() < 0.2 and 0.85 < colours.max() <= 0.9 + ROUNDING32
    apart = np.abs(np.diff(colours, axis=0)).max(axis=1)
    assert np.median(apart) > 0.2, "neighbours in number are far apart"


def test_values_take_their_row_of_the_colour_map(call):
    colour_map = np.random.default_rng(0).uniform(0, 1, (256, 4)).astype(np.float32)
    values = np.array([0, 1, 0.5, -3, 7, 0.1, np.inf, -np.inf], np.float32)
    found = call(
        f"const planes8 e = mapped_colour(colour_map, vload8(0, values)); {STORE}",
        1,
        {"out": (24, np.float32)},
        colour_map=colour_map,
        values=values,
    )
    rows = [0, 255, 128, 0, 255, 26, 255, 0]
    np.testing.assert_array_equal(lanes(found["out"]), colour_map[rows, :3])


def test_value_that_is_not_a_number_stays_within_the_colour_map(call):
    found = call(
        f"const planes8 e = mapped_colour(colour_map, vload8(0, values)); {STORE}",
        1,
        {"out": (24, np.float32)},
        colour_map=np.full((256, 4), 0.5, np.float32),
        values=np.full(8, np.nan, np.float32),
    )
    assert (found["out"] == 0.5).all()


def test_row_sees_the_nearest_of_the_maps_that_are_open(call):
    rng, maps, tiles, tile, row = np.random.default_rng(0), 3, 2, 1, 5
    keys = (rng.integers(0, 0x3F800000, (maps, tiles, 64, 64)) << 32) | rng.integers(
        0, 9, (maps, tiles, 64, 64)
    )
    keys[:, :, row, 8:16] = EMPTY_KEY
    keys[2] = 1  # would win everywhere, but was not opened
    found = call(
        """uint own[64];
    const size_t opened[2] = {4096 * 1, 4096 * 3};
    hits[0] = row_ids(keys, opened, 2, own, 0, 9, 5);
    for (int k = 0; k < 64; ++k) ids[k] = own[k];""",
        1,
        {"hits": (1, np.uint32), "ids": (64, np.uint32)},
        keys=keys,
    )
    expected = keys[:2, tile, row].min(axis=0) & 0xFFFFFFFF
    np.testing.assert_array_equal(found["ids"], expected)
    assert found["hits"][0] == 0b11111101


def test_row_of_one_surface_of_several_sees_its_own_ids_alone(device, tmp_path):
    rng = np.random.default_rng(0)
    keys = rng.integers(0, 12, (1, 1, 64, 64)).astype(np.int64)
    keys[..., 2, :8] = EMPTY_KEY
    found = caller(device, tmp_path, several=1)(
        """uint own[64];
    const size_t opened[1] = {0};
    hits[0] = row_ids(keys, opened, 1, own, 4, 5, 2);
    for (int k = 0; k < 64; ++k) ids[k] = own[k];""",
        1,
        {"hits": (1, np.uint32), "ids": (64, np.uint32)},
        keys=keys,
    )
    ids = keys[0, 0, 2] & 0xFFFFFFFF
    expected = np.where((ids >= 4) & (ids < 9), ids - 4, 0xFFFFFFFF)
    np.testing.assert_array_equal(found["ids"], expected)


@pytest.mark.parametrize("instanced", [0, 1])
def test_triangle_of_an_instance_has_its_corners_after_those_before(device, tmp_path, instanced):
    topology = np.random.default_rng(0).integers(0, 6, (12, 3)).astype(np.uint32)
    found = caller(device, tmp_path, instanced)(
        "vstore3(triangle_corners(topology, i, 4, 6), i, out);",
        12,
        {"out": (36, np.uint32)},
        topology=topology,
    )
    k = np.arange(12)
    expected = topology[k % 4] + 6 * (k // 4)[:, None] if instanced else topology
    np.testing.assert_array_equal(found["out"].reshape(-1, 3), expected)
