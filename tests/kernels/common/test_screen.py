import numpy as np
import pytest

from lodbench.kernels.stages import drawing, raster, raster_reference
from tests.kernels.common.calling import Caller


@pytest.fixture(scope="module")
def call(device, tmp_path_factory):
    return Caller(device, tmp_path_factory.mktemp("kernels"), "common/screen.cl")


def test_constants_are_those_of_the_host_and_the_reference(call):
    found = call(
        """out[0] = SUBPIXELS; out[1] = (long)GUARD; out[2] = TILE; out[3] = TILE_PIXELS; out[4] = FLAGS_OPEN;
    out[5] = KEY_EMPTY; out[6] = ID_EMPTY; out[7] = OUTSIDE;
    out[8] = OUTSIDE_NEAR | OUTSIDE_LEFT | OUTSIDE_RIGHT | OUTSIDE_TOP | OUTSIDE_BOTTOM; out[9] = OUTSIDE_ANY;
    const int8 lane = LANE; vstore8(convert_long8(lane), 0, out + 10);""",
        1,
        {"out": (18, np.int64)},
    )["out"].tolist()
    assert found[:2] == [raster_reference.SUBPIXELS, int(raster_reference.GUARD)]
    assert found[2:5] == [raster.TILE, raster.TILE**2, drawing.COUNTERS]
    assert found[5:7] == [raster.EMPTY_KEY, raster.EMPTY_ID]
    assert found[7] == np.iinfo(np.int32).min, "negative with any outcode added"
    assert found[8] == found[9] == 31
    assert found[10:] == list(range(8))


def test_coordinates_are_rounded_half_up(call):
    x = np.array([0, 0.49, 0.5, 1.5, -0.5, -0.51, -1.5, 4194303.25], np.float32)
    found = call("vstore8(screen_round(vload8(0, x)), 0, out);", 1, {"out": (8, np.int32)}, x=x)
    assert found["out"].tolist() == [0, 0, 1, 2, 0, -1, -1, 4194303]


def test_lanes_are_compared_and_reduced(call):
    rng = np.random.default_rng(0)
    a = rng.integers(-(2**31), 2**31, (64, 8)).astype(np.int32)
    a[0], a[1] = 0, -1
    x, y = rng.normal(size=(2, 64, 8)).astype(np.float32)
    found = call(
        """const int8 lanes = vload8(i, a);
    signs[i] = lane_signs(lanes);
    largest[i] = largest_lane(lanes);
    smallest[i] = smallest_lane(as_uint8(lanes));
    vstore8(lesser(vload8(i, x), vload8(i, y)), i, low);
    vstore8(greater(vload8(i, x), vload8(i, y)), i, high);
    one[i] = lesser(x[i], y[i]) - greater(x[i], y[i]);""",
        64,
        {
            "signs": (64, np.uint32), "largest": (64, np.int32), "smallest": (64, np.uint32),
            "low": (512, np.float32), "high": (512, np.float32), "one": (64, np.float32),
        },
        a=a, x=x, y=y,
    )  # fmt: skip
    np.testing.assert_array_equal(found["signs"], ((a < 0) << np.arange(8)).sum(axis=1))
    np.testing.assert_array_equal(found["largest"], a.max(axis=1))
    np.testing.assert_array_equal(found["smallest"], a.view(np.uint32).min(axis=1))
    np.testing.assert_array_equal(found["low"], np.minimum(x, y).ravel())
    np.testing.assert_array_equal(found["high"], np.maximum(x, y).ravel())
    np.testing.assert_array_equal(found["one"], -np.abs(x - y).ravel()[:64])
