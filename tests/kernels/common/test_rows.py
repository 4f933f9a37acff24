import numpy as np
import pytest

from tests.kernels.common.calling import Caller


@pytest.fixture(scope="module")
def call(device, tmp_path_factory):
    return Caller(device, tmp_path_factory.mktemp("kernels"), "common/rows.cl")


@pytest.mark.parametrize("count", [1, 2, 3, 7, 64, 1000])
def test_row_of_a_place_is_the_one_that_it_lies_in(call, count):
    lengths = np.random.default_rng(count).integers(1, 9, count)
    offsets = (np.cumsum(lengths) - lengths).astype(np.uint32)
    total = int(lengths.sum())
    found = call(
        "out[i] = row_of(offsets, rows[0], i);", total, {"out": (total, np.uint32)},
        offsets=offsets, rows=np.array([count], np.uint32),
    )  # fmt: skip
    np.testing.assert_array_equal(found["out"], np.repeat(np.arange(count), lengths))


def test_rows_without_places_are_passed_over(call):
    offsets = np.array([0, 0, 2, 2, 2, 5], np.uint32)
    found = call(
        "out[i] = row_of(offsets, rows[0], i);", 6, {"out": (6, np.uint32)},
        offsets=offsets, rows=np.array([6], np.uint32),
    )  # fmt: skip
    assert found["out"].tolist() == [1, 1, 4, 4, 4, 5]
