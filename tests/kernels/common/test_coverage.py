import numpy as np
import pytest

from lodbench.kernels.stages import raster_reference
from lodbench.kernels.stages.raster import EMPTY_KEY
from tests.kernels.common.calling import Caller
from tests.tolerances import ROUNDING32

WIDTH, HEIGHT = 100, 50  # two tiles side by side, neither of them full
WALK = """Walk walk;
    started[i] = walk_start(&walk, vload4(3 * i, corners), vload4(3 * i + 1, corners),
        vload4(3 * i + 2, corners), 7 + i, 100, 50, cull);
    if (started[i])
        for (int tile = 0; tile < 2; ++tile)
            walk_tile(&walk, keys + (2 * i + tile) * TILE_PIXELS, tile * TILE, 0);"""


@pytest.fixture(scope="module", params=["keys", "counts"])
def call(request, device, tmp_path_factory):
    defines = {"COUNT": 1} if request.param == "counts" else {}
    made = Caller(device, tmp_path_factory.mktemp("kernels"), "common/coverage.cl", **defines)
    made.counts = bool(defines)
    return made


def triangles():
    """(n, 3) x, (n, 3) y in sub-pixels, (n, 3) depths: any, in and across the image, some on pixel centres."""
    rng = np.random.default_rng(0)
    places = rng.uniform(-0.3, 1.3, (40, 3, 2)) * (256 * WIDTH, 256 * HEIGHT)
    places[:10] = 256 * rng.integers(0, 50, (10, 3, 2)) + 128
    places[10:20] = places[10:20].mean(axis=1, keepdims=True) + rng.uniform(-400, 400, (10, 3, 2))
    corners = np.zeros((42, 3, 4), np.int32)
    corners[:40, :, :2] = places
    corners[40, :, :2] = (300, 300), (900, 900), (600, 600)  # no area
    corners[41, :, :2] = (130, 130), (380, 130), (130, 380)  # no centre within
    corners[:, :, 2] = rng.uniform(0.1, 0.9, (42, 3)).astype(np.float32).view(np.int32)
    return corners


@pytest.mark.parametrize("cull", [0, 1])
def test_triangle_covers_the_pixels_that_the_reference_says(call, cull):
    corners = triangles()
    n = len(corners)
    keys = np.full(n * 2 * 64 * 64, 0 if call.counts else EMPTY_KEY, np.int64)
    found = call(WALK, n, {"keys": keys, "started": (n, np.uint8)}, corners=corners, cull=cull)
    assert not found["started"][40:].any()
    maps = found["keys"].reshape(n, 2, 64, 64)
    covered = 0
    for k, (triangle, tiles) in enumerate(zip(corners, maps, strict=True)):
        image = np.concatenate(list(tiles), axis=1)
        assert (image[HEIGHT:] == (0 if call.counts else EMPTY_KEY)).all()
        image = image[:HEIGHT, :WIDTH]  # what lies beside it in a tile is nobody's
        given = [(int(x), int(y), np.int32(z).view(np.float32)) for x, y, z, _ in triangle]
        expected = {
            (row, column): z
            for column, row, z in raster_reference.fragments(*given, WIDTH, HEIGHT, bool(cull))
        }
        drawn = {
            (int(r), int(c)) for r, c in np.argwhere(image != (0 if call.counts else EMPTY_KEY))
        }
        assert drawn == set(expected)
        covered += len(drawn)
        if call.counts:
            assert all(image[place] == 1 for place in drawn)
            continue
        depths = {z for _, _, z in given}
        for place, z in expected.items():
            depth = np.int32(image[place] >> 32).view(np.float32)
            assert image[place] & 0xFFFFFFFF == 7 + k
            assert abs(depth - z) <= ROUNDING32 * max(depths)
    assert covered > 5000


def test_pixel_centres_between_two_coordinates_are_found(call):
    low, high = np.meshgrid(np.arange(-600, 600, 37), np.arange(-600, 600, 41), indexing="ij")
    low, high = low.ravel().astype(np.int32), high.ravel().astype(np.int32)
    found = call(
        "first[i] = first_centre(low[i]); last[i] = last_centre(high[i]);",
        len(low),
        {"first": (len(low), np.int32), "last": (len(low), np.int32)},
        low=low,
        high=high,
    )
    centres = 256 * np.arange(-5, 6) + 128
    for bottom, top, first, last in zip(low, high, found["first"], found["last"], strict=True):
        within = np.flatnonzero((centres >= bottom) & (centres <= top)) - 5
        assert list(range(first, last + 1)) == within.tolist()
