from itertools import permutations

import numpy as np
import pytest

from tests.kernels.common.calling import Caller

KEYS = np.random.default_rng(0).integers(0, 2**32, (1000, 3), dtype=np.uint32)
KEYS[:200] //= 2**28  # small ones, with equal corners among them
KEYS[0] = 2**32 - 1


@pytest.fixture(scope="module")
def call(device, tmp_path_factory):
    return Caller(device, tmp_path_factory.mktemp("kernels"), "common/corners.cl")


def test_corners_are_sorted_whichever_way_the_triangle_turns(call):
    for order in permutations(range(3)):
        found = call(
            "vstore3(corners_sorted(vload3(i, keys)), i, out);",
            len(KEYS),
            {"out": (KEYS.size, np.uint32)},
            keys=KEYS[:, order],
        )
        np.testing.assert_array_equal(found["out"].reshape(-1, 3), np.sort(KEYS, axis=1))


def test_corners_are_the_same_where_all_three_are(call):
    other = np.tile(KEYS[1], (8, 1)) ^ ((np.arange(8)[:, None] >> np.arange(3)) & 1).astype("u4")
    found = call(
        "out[i] = corners_same(vload3(0, key), vload3(i, other));",
        8,
        {"out": (8, np.uint8)},
        key=KEYS[1],
        other=other,
    )
    assert found["out"].tolist() == [1] + [0] * 7


@pytest.mark.parametrize("bits", [0, 4, 12])
@pytest.mark.parametrize("step", [1, 4096, 2**20])
def test_slots_of_neighbouring_triangles_are_spread_over_the_table(call, bits, step):
    first = np.arange(4096, dtype=np.uint32) * np.uint32(step)
    keys = first[:, None] + np.arange(3, dtype=np.uint32)
    found = call(
        "out[i] = corners_slot(vload3(i, keys), mask[0]);",
        len(keys),
        {"out": (len(keys), np.uint32)},
        keys=keys,
        mask=np.array([2**bits - 1], np.uint32),
    )
    counts = np.bincount(found["out"], minlength=2**bits)
    assert len(counts) == 2**bits, "no slot beyond the mask"
    if bits == 12:  # one per slot on average: 63 % of the slots are taken where they fall at random
        assert (counts > 0).mean() > 0.5
        assert counts.max() < 16
    else:
        assert counts.min() > 0.7 * counts.mean()
