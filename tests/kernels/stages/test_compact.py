import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.kernels.opencl.device import Device
from lodbench.kernels.opencl.timeline import Timeline
from lodbench.kernels.stages.compact import Compact
from lodbench.kernels.stages.scan import CHUNK_ROWS

UNTOUCHED = 0xDEADBEEF


def compact(device, flags, rows, live=None):
    """(kept rows, kept indices, whole target): the target starts out as UNTOUCHED."""
    flags = np.asarray(flags, np.uint8)
    rows = np.ascontiguousarray(rows)
    source = device.upload("rows", rows)
    blank = np.full(rows.nbytes // 4, UNTOUCHED, np.uint32).view(rows.dtype).reshape(rows.shape)
    target = device.upload("kept_rows", blank)
    indices = device.upload("indices", np.full(len(flags), UNTOUCHED, np.uint32))
    total = device.upload("total", np.array([UNTOUCHED], np.uint32))
    count = None if live is None else device.upload("live", np.array([live], np.uint32))
    made = Compact(
        device, device.upload("flags", flags), total,
        rows=[(source, target)], indices=indices, live=count,
    )  # fmt: skip
    made(Timeline())
    device.wait()
    kept = int(device.read(total)[0])
    whole = device.read(target)
    assert (whole[kept:].view(np.uint32) == UNTOUCHED).all(), "written past the kept rows"
    assert (device.read(indices)[kept:] == UNTOUCHED).all()
    return whole[:kept], device.read(indices)[:kept]


def assert_compacted(device, flags, rows, live=None):
    kept, indices = compact(device, flags, rows, live)
    wanted = np.flatnonzero(np.asarray(flags)[:live])
    np.testing.assert_array_equal(indices, wanted)
    np.testing.assert_array_equal(kept.view(np.uint32), rows[wanted].view(np.uint32))


@pytest.mark.parametrize(
    "size", [0, 1, 15, 16, 17, 511, 512, 513, CHUNK_ROWS - 1, 3 * CHUNK_ROWS + 5]
)
@pytest.mark.parametrize("share", [0.0, 0.02, 0.5, 1.0])
def test_compact_keeps_flagged_rows_in_order(device, size, share):
    random = np.random.default_rng(size)
    rows = random.integers(0, 2**32, (size, 3), dtype=np.uint32)
    assert_compacted(device, random.random(size) < share, rows)


@settings(max_examples=40, deadline=None)
@given(
    size=st.integers(0, 60_000),
    seed=st.integers(0, 2**32 - 1),
    share=st.floats(0, 1),
    width=st.integers(1, 9),
)
def test_compact_equals_boolean_indexing(device, size, seed, share, width):
    random = np.random.default_rng(seed)
    rows = random.integers(0, 2**32, (size, width), dtype=np.uint32)
    assert_compacted(device, random.random(size) < share, rows)


def test_compact_takes_any_flag_that_is_not_zero(device):
    flags = np.arange(1000) % 256
    assert_compacted(device, flags, np.arange(1000, dtype=np.uint32))


def test_compact_moves_floats_bit_by_bit(device):
    rows = np.random.default_rng(1).integers(0, 2**32, (5000, 4), dtype=np.uint32)
    # random bits hold NaN of every payload: a copy through float arithmetic would change some
    assert_compacted(device, np.arange(5000) % 3 == 0, rows.view(np.float32))


def test_compact_moves_rows_of_several_bytes_that_fill_whole_words(device):
    rows = np.random.default_rng(1).integers(0, 256, (5000, 8), dtype=np.uint8)
    assert_compacted(device, np.arange(5000) % 3 == 0, rows)


@pytest.mark.parametrize("live", [0, 1, 5000, 13_999, 14_000])
def test_compact_stops_at_the_live_count_kept_on_the_device(device, live):
    flags = np.ones(14_000)
    assert_compacted(device, flags, np.arange(14_000, dtype=np.uint32), live)


@pytest.mark.parametrize("local_size", [1, 7, 256])
def test_compact_does_not_depend_on_the_work_group_size_or_on_the_cores(local_size):
    flags = np.random.default_rng(4).random(50_001) < 0.3
    other = Device.open(local_size=local_size, one_core=True)
    assert_compacted(other, flags, np.arange(50_001, dtype=np.uint32))


def test_compact_moves_several_arrays_of_unequal_width(device):
    flags = np.arange(300) % 2
    sources = [np.arange(300, dtype=np.uint32), np.arange(900, dtype=np.float32).reshape(300, 3)]
    pairs = [
        (device.upload("source", s), device.allocate("target", s.shape, s.dtype)) for s in sources
    ]
    total = device.allocate("total", 1, np.uint32)
    Compact(device, device.upload("flags", flags.astype(np.uint8)), total, rows=pairs)(Timeline())
    assert device.read(total)[0] == 150
    for source, (_, target) in zip(sources, pairs, strict=True):
        np.testing.assert_array_equal(device.read(target, 150), source[1::2])


def test_compact_refuses_what_it_cannot_move(device):
    flags = device.allocate("flags", 10, np.uint8)
    words = device.allocate("words", 10, np.uint32)
    total = device.allocate("total", 1, np.uint32)
    triples = device.allocate("triples", (10, 3), np.uint32)
    short = device.allocate("short", 9, np.uint32)
    bytes3 = device.allocate("colours", (10, 3), np.uint8)
    with pytest.raises(TypeError, match="words: expected uint8, got uint32"):
        Compact(device, words, total, indices=words)
    with pytest.raises(ValueError, match="rows: expected pairs"):
        Compact(device, flags, total)
    with pytest.raises(ValueError, match="short: expected at least 10 rows, got 9"):
        Compact(device, flags, total, rows=[(words, short)])
    with pytest.raises(ValueError, match="triples: expected rows like words's"):
        Compact(device, flags, total, rows=[(words, triples)])
    with pytest.raises(ValueError, match="of whole 4-byte words"):
        Compact(device, flags, total, rows=[(bytes3, bytes3)])


def test_live_rows_above_the_capacity_mean_all_of_them(device):
    random = np.random.default_rng(1)
    rows = random.integers(0, 2**32, (18_097, 2), dtype=np.uint32)
    assert_compacted(device, random.random(18_097) < 0.5, rows, live=18_097 + 1000)
