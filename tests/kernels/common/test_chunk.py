import numpy as np
import pytest

from tests.kernels.common.calling import Caller


@pytest.fixture(scope="module")
def call(device, tmp_path_factory):
    return Caller(device, tmp_path_factory.mktemp("kernels"), "common/chunk.cl")


@pytest.mark.parametrize("chunk_count", [1, 3, 16, 64])
@pytest.mark.parametrize("row_count", [0, 1, 15, 16, 17, 1000, 4097, 2**32 - 1])
def test_chunks_are_whole_cache_lines_that_share_all_rows_between_them(
    call, chunk_count, row_count
):
    found = call(
        "vstore2(chunk_rows(i, count, rows[0]), i, out);",
        chunk_count,
        {"out": (2 * chunk_count, np.uint32)},
        rows=np.array([row_count], np.uint32),
    )
    begin, end = found["out"].reshape(-1, 2).T.astype(np.int64)
    assert (begin[0], end[-1]) == (0, row_count)
    assert (begin[1:] == end[:-1]).all()
    assert (end >= begin).all()
    assert ((begin % 16 == 0) | (begin == row_count)).all()
    lines = -(-row_count // 16)
    assert (end - begin).max() <= 16 * -(-lines // chunk_count), "as even as lines allow"


def test_sum_before_a_chunk_leaves_itself_out(call):
    sums = np.random.default_rng(0).integers(0, 1000, 40).astype(np.uint32)
    found = call("out[i] = chunk_sum_before(i, sums);", 40, {"out": (40, np.uint32)}, sums=sums)
    np.testing.assert_array_equal(found["out"], np.cumsum(sums) - sums)
