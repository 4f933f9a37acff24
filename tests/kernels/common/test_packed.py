import numpy as np
import pytest

from tests.kernels.common.calling import Caller
from tests.tolerances import ROUNDING32, UNIT_LENGTH


@pytest.fixture(scope="module", params=[0, 1], ids=["cached", "streaming"])
def call(request, device, tmp_path_factory):
    folder = tmp_path_factory.mktemp("kernels")
    return Caller(device, folder, "common/packed.cl", STREAMING=request.param)


PLANES = "const planes8 a = {vload8(i, x), vload8(i, y), vload8(i, z)};\n    "


def planes(rows):
    return dict(zip("xyz", rows.astype(np.float32).T, strict=True))


def test_planes_are_stored_as_packed_rows(call):
    rows = np.arange(8 * 5 * 3).reshape(-1, 3)
    found = call(
        PLANES + "packed_store8(a, out + 24 * i);", 5, {"out": (120, np.float32)}, **planes(rows)
    )
    np.testing.assert_array_equal(found["out"].reshape(-1, 3), rows)


@pytest.mark.parametrize(("first", "end"), [(0, 8), (0, 24), (3, 5), (3, 21), (8, 9), (13, 16)])
def test_parts_of_vectors_are_written_where_they_belong_and_nowhere_else(call, first, end):
    found = call(
        """packed_stage stage;
    uint v = first, taken;
    stage.first = stage.end = v & 7;
    const float8 lanes = (float8)(0, 1, 2, 3, 4, 5, 6, 7);
    for (uint length = 1; v < (uint)end; v += taken, length = length % 3 + 1) {
        taken = min(min(length, 8 - (v & 7)), (uint)end - v); // parts of one, two and three
        const planes8 p = {lanes + v, lanes + v + 100, lanes + v + 200}, n = {-p.x, -p.y, -p.z};
        packed_stage_put(&stage, p, n, taken, v, positions, normals);
    }
    if (stage.end) packed_stage_flush(&stage, v & ~7u, positions, normals);""",
        1,
        {name: np.full(96, 0.5, np.float32) for name in ("positions", "normals")},
        first=first,
        end=end,
    )
    v = np.arange(32)[:, None] + np.array([0, 100, 200])
    own = (np.arange(32) >= first) & (np.arange(32) < end)
    for name, sign in (("positions", 1), ("normals", -1)):
        expected = np.where(own[:, None], sign * v, 0.5)
        np.testing.assert_array_equal(found[name].reshape(-1, 3), expected)


def test_span_is_origin_and_two_edges(call):
    rng = np.random.default_rng(0)
    u, v = rng.uniform(-1, 1, (2, 64)).astype(np.float32)
    frame = rng.normal(size=(3, 3)).astype(np.float32)
    found = call(
        """const float3 origin = vload3(0, frame), a = vload3(1, frame), b = vload3(2, frame);
    const planes8 sum = planes8_span(vload8(i, u), vload8(i, v), origin, a, b);
    packed_store8(sum, out + 24 * i);""",
        8,
        {"out": (192, np.float32)},
        u=u, v=v, frame=frame,
    )  # fmt: skip
    origin, a, b = frame.astype(float)
    expected = origin + u[:, None] * a + v[:, None] * b
    assert np.abs(found["out"].reshape(-1, 3) - expected).max() <= ROUNDING32 * np.abs(frame).max()


def test_lanes_are_picked_by_their_mask(call):
    rows = np.arange(24).reshape(-1, 3)
    mask = np.array([-1, 0, 0, -1, -1, 0, -1, 0], np.int32)
    found = call(
        PLANES + "const planes8 b = {-a.x, -a.y, -a.z};\n"
        "packed_store8(planes8_pick(vload8(0, mask), a, b), out);",
        1,
        {"out": (24, np.float32)},
        mask=mask,
        **planes(rows + 1),
    )
    expected = np.where(mask[:, None] != 0, rows + 1, -rows - 1)
    np.testing.assert_array_equal(found["out"].reshape(-1, 3), expected)


def test_normals_have_unit_length_and_a_direction_where_there_was_none(call):
    rng = np.random.default_rng(0)
    rows = rng.normal(size=(64, 3)) * 10.0 ** rng.uniform(-13, 13, (64, 1))
    rows[:3] = (0, 0, 0), (1e-16, 0, 0), (0, -1e-20, -1e-20)
    rows[3] = 0, 0, -5
    found = call(
        PLANES + "packed_store8(planes8_normalise(a), out + 24 * i);",
        8,
        {"out": (192, np.float32)},
        **planes(rows),
    )["out"].reshape(-1, 3)
    np.testing.assert_array_equal(found[:3], [[0, 0, 1]] * 3)
    length = np.linalg.norm(rows[3:], axis=1, keepdims=True)
    assert np.abs(found[3:] - rows[3:] / length).max() <= UNIT_LENGTH
