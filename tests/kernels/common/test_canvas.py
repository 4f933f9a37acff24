import numpy as np
import pytest

from lodbench.kernels.stages import raster_reference
from lodbench.kernels.stages.raster import EMPTY_KEY
from tests.kernels.common.calling import Caller

WIDTH, HEIGHT = 100, 130  # two tiles by three
TILES = 6
CANVAS = """const Canvas canvas = {keys, open, queue, large, 100, 130, 2, capacity, pixels, 0};
    """
FOCUS, NEAR = 60.0, 0.1
TO_SCREEN = 256 * np.array(  # a camera at the origin that looks along -z
    [
        [FOCUS, 0, -WIDTH / 2, 0],
        [0, -FOCUS, -HEIGHT / 2, 0],
        [0, 0, -1 / 256, -NEAR / 256],
        [0, 0, -1 / 256, 0],
    ],
    np.float32,
)


@pytest.fixture(scope="module")
def call(device, tmp_path_factory):
    return Caller(device, tmp_path_factory.mktemp("kernels"), "common/canvas.cl")


def canvas():
    """What a canvas draws into: tiles that nobody has opened hold rubbish, and nobody may look at them."""
    return {
        "keys": np.full(TILES * 64 * 64, -77, np.int64),
        "open": (TILES, np.uint32),
        "queue": (2, np.uint32),
        "large": (64, np.int32),
    }


def image(found):
    """Depths and ids (height, width) of the opened tiles; elsewhere nothing is drawn."""
    tiles = found["keys"].reshape(3, 2, 64, 64)
    tiles = np.where(found["open"].reshape(3, 2, 1, 1) != 0, tiles, EMPTY_KEY)
    whole = tiles.transpose(0, 2, 1, 3).reshape(192, 128)
    assert (whole[HEIGHT:] == EMPTY_KEY).all(), "what lies beside the image in a tile is nobody's"
    keys = whole[:HEIGHT, :WIDTH]
    return (keys >> 32).astype(np.int32).view(np.float32), (keys & 0xFFFFFFFF).astype(np.uint32)


SMALL = np.array(
    [[[9000, 9000, 0, 0], [12000, 20000, 0, 0], [20000, 9500, 0, 0]]] * 2, np.int32
)  # across the four upper tiles
SMALL[1] += (300, 800, 0, 0)
SMALL[:, :, 2] = np.float32([[0.3, 0.4, 0.5], [0.5, 0.4, 0.2]]).view(np.int32)
DRAW = (
    CANVAS
    + """for (int k = 0; k < 2; ++k)
        canvas_draw(&canvas, vload4(3 * k, corners), vload4(3 * k + 1, corners), vload4(3 * k + 2, corners), 40 + k);"""
)


def fragments(order):
    """(row, column) -> id of the nearest of SMALL, drawn in this order."""
    nearest = {}
    for k in order:
        corners = [(int(x), int(y), np.int32(z).view(np.float32)) for x, y, z, _ in SMALL[k]]
        for column, row, z in raster_reference.fragments(*corners, WIDTH, HEIGHT):
            nearest[row, column] = min(nearest.get((row, column), (2, 0)), (z, 40 + k))
    return {place: found for place, (_, found) in nearest.items()}


def test_nearest_triangle_stays_in_tiles_that_were_opened_for_it(call):
    found = call(DRAW, 1, canvas(), corners=SMALL, capacity=4, pixels=1 << 20)
    _, ids = image(found)
    expected = fragments([0, 1])
    assert {tuple(place): ids[tuple(place)] for place in np.argwhere(ids != 0xFFFFFFFF)} == expected
    assert {40, 41} == set(expected.values())
    assert found["open"].tolist() == [1, 1, 1, 1, 0, 0]
    assert (found["keys"].reshape(TILES, -1)[4:] == -77).all()
    assert found["queue"].tolist() == [0, 0]


def test_large_triangle_is_queued_with_its_box_while_there_is_room(call):
    found = call(DRAW, 1, canvas(), corners=SMALL, capacity=1, pixels=64)
    assert found["queue"][1] == 2, "the one too many is counted, and drawn here"
    _, ids = image(found)
    assert set(np.unique(ids)) == {41, 0xFFFFFFFF}
    first, *corners = found["large"][:16].reshape(4, 4).tolist()
    low, high = SMALL[0, :, :2].min(axis=0), SMALL[0, :, :2].max(axis=0)
    assert first == [*((low + 127) >> 8), *((high - 128) >> 8)]
    assert [corner[:3] for corner in corners] == SMALL[0, :, :3].tolist()
    assert corners[0][3] == 40
    assert (found["large"][16:] == 0).all()


def test_clipped_triangles_are_drawn_as_the_reference_draws_them(call):
    rng = np.random.default_rng(3)
    positions = rng.normal(0, (2, 2, 1), (24, 3)).astype(np.float32) - np.float32((0, 0, 1.5))
    assert (positions[:, 2] > -NEAR).any()
    found = call(
        CANVAS
        + """for (int k = 0; k < 8; ++k)
        canvas_clip(&canvas, vload3(3 * k, positions), vload3(3 * k + 1, positions), vload3(3 * k + 2, positions),
            vload16(0, m), k);""",
        1,
        canvas(),
        positions=positions,
        m=TO_SCREEN.ravel(),
        capacity=0,
        pixels=1 << 20,
    )
    depths, ids = image(found)
    triangles = np.arange(24, dtype=np.uint32).reshape(-1, 3)
    expected = raster_reference.draw(positions, triangles, TO_SCREEN.ravel(), WIDTH, HEIGHT)
    assert len(np.unique(expected[1])) > 4
    assert (ids != expected[1]).mean() < 1e-3, "a corner may round to the next sub-pixel"
    same = ids == expected[1]
    assert np.abs(depths - expected[0])[same].max() < 1e-3


@pytest.mark.parametrize("shared", [False, True])
def test_fragments_of_eight_triangles_at_a_time_reach_their_pixels(device, tmp_path, call, shared):
    if shared:
        if "cl_khr_int64_extended_atomics" not in device.facts.extensions:
            pytest.skip("this device has no 64-bit atomics")
        extension = "#pragma OPENCL EXTENSION cl_khr_int64_extended_atomics : enable"
        call = Caller(device, tmp_path, "common/canvas.cl", extension, SHARED=1)
    rng = np.random.default_rng(4)
    rounds = 20  # of 64 slots: more than wait at once
    pixels = rng.integers(0, 2 * 4096, (rounds, 64)).astype(np.uint32)
    pixels[:, ::3] %= 97  # many in one place
    depths = rng.uniform(0, 1, (rounds, 64)).astype(np.float32).view(np.uint32)
    bits = rng.integers(-(2**63), 2**63, rounds)
    bits[:2] = 0, -1
    start = canvas()
    if shared:
        start["keys"] = np.full(TILES * 64 * 64, EMPTY_KEY, np.int64)
    found = call(
        CANVAS
        + """Waiting waiting;
    waiting.count = 0;
    uint own_places[64], own_depths[64];
    for (int k = 0; k < rounds; ++k) {
        for (int slot = 0; slot < 64; ++slot) {
            own_places[slot] = places[64 * k + slot];
            own_depths[slot] = depths[64 * k + slot];
        }
        canvas_put(&canvas, &waiting, (ulong)bits[k], own_places, own_depths, 8 * k);
    }
    waiting_put(&canvas, &waiting);""",
        1,
        start,
        places=pixels,
        depths=depths,
        bits=bits,
        capacity=0,
        pixels=1,
        rounds=rounds,
    )
    expected = np.full(TILES * 64 * 64, EMPTY_KEY, np.int64)
    present = (bits[:, None] >> np.arange(64)) & 1 != 0
    ids = 8 * np.arange(rounds)[:, None] + np.arange(64) % 8
    keys = (depths.astype(np.int64) << 32) | ids
    np.minimum.at(expected, pixels[present], keys[present])
    touched = 2 * 64 * 64
    np.testing.assert_array_equal(found["keys"][:touched], expected[:touched])
    assert found["open"].tolist() == ([0] * 6 if shared else [1, 1, 0, 0, 0, 0])
