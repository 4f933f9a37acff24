import numpy as np
import pytest

from tests.kernels.common.calling import Caller
from tests.kernels.common.test_canvas import CANVAS, HEIGHT, WIDTH, canvas, image

EIGHT = (
    CANVAS
    + """Waiting waiting;
    waiting.count = 0;
    uint own[24];
    for (uint k = 0; k < 24; ++k) own[k] = min(k, 3u * (uint)live - 1u);
    left[0] = canvas_draw_eight(&canvas, &waiting, screen, own, 40, (uint)live);
    waiting_put(&canvas, &waiting);"""
)
ONE_BY_ONE = (
    CANVAS
    + """for (int k = 0; k < live; ++k)
        canvas_draw(&canvas, vload4(3 * k, screen), vload4(3 * k + 1, screen), vload4(3 * k + 2, screen), 40 + k);"""
)


@pytest.fixture(scope="module")
def call(device, tmp_path_factory):
    return Caller(device, tmp_path_factory.mktemp("kernels"), "common/eight.cl")


@pytest.mark.parametrize("size", [1, 4, 7, 20, 40])
@pytest.mark.parametrize("live", [1, 5, 8])
def test_eight_triangles_are_drawn_as_one_by_one(call, size, live):
    rng = np.random.default_rng(size)
    middle = rng.uniform((0, 0), (WIDTH, HEIGHT), (8, 1, 2))
    screen = np.zeros((24, 4), np.int32)
    places = 256 * (middle + rng.uniform(-size / 2, size / 2, (8, 3, 2)))
    screen[:, :2] = places.astype(int).reshape(-1, 2)
    screen[:, 2] = rng.uniform(0.1, 0.9, 24).astype(np.float32).view(np.int32)
    screen[:, 3] = np.float32(1).view(np.int32)
    given = {"screen": screen, "live": live, "capacity": 4, "pixels": 1 << 20}
    found = call(EIGHT, 1, canvas() | {"left": (1, np.uint32)}, **given)
    assert found["left"][0] == 0, "all are small"
    for have, want in zip(image(found), image(call(ONE_BY_ONE, 1, canvas(), **given)), strict=True):
        np.testing.assert_array_equal(have, want)
