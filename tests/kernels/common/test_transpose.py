import numpy as np
import pytest

from tests.kernels.common.calling import Caller


@pytest.fixture
def call(device, tmp_path):
    return Caller(device, tmp_path, "common/transpose.cl")


def test_lanes_are_picked_from_two_vectors(call):
    found = call(
        """const int8 a = vload8(0, lanes), b = a + 8;
    vstore8(SHUFFLE8(a, b, 0, 8, 1, 9, 7, 15, 6, 14), 0, out);
    vstore16(SHUFFLE16(a, b, 15, 14, 13, 12, 11, 10, 9, 8, 0, 1, 2, 3, 4, 5, 6, 7), 0, wide);""",
        1,
        {"out": (8, np.int32), "wide": (16, np.int32)},
        lanes=np.arange(8, dtype=np.int32),
    )
    assert found["out"].tolist() == [0, 8, 1, 9, 7, 15, 6, 14]
    assert found["wide"].tolist() == [*range(15, 7, -1), *range(8)]


STORE = "vstore8(t.x, 0, out); vstore8(t.y, 1, out); vstore8(t.z, 2, out); vstore8(t.w, 3, out);"


def test_records_become_planes_and_planes_records(call):
    records = np.random.default_rng(0).random((8, 4)).astype(np.float32)
    rows = records[[0, 4, 1, 5, 2, 6, 3, 7]]  # four vectors of two records
    body = (
        "const fours8 t = transpose_fours(vload8(0, a), vload8(1, a), vload8(2, a), vload8(3, a)); "
    )
    planes = call(body + STORE, 1, {"out": (32, np.float32)}, a=rows)["out"]
    np.testing.assert_array_equal(planes.reshape(4, 8), records.T)
    back = call(body + STORE, 1, {"out": (32, np.float32)}, a=planes)["out"]
    np.testing.assert_array_equal(back.reshape(8, 4), rows)
