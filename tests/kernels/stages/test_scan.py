import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodbench.kernels.opencl.device import Device
from lodbench.kernels.opencl.timeline import Timeline
from lodbench.kernels.stages.scan import CHUNK_ROWS, ExclusiveScan, chunk_count

UNTOUCHED = 0xDEADBEEF


def scan(device, counts, live=None, in_place=False):
    counts = np.asarray(counts, np.uint32)
    source = device.upload("counts", counts)
    offsets = source
    if not in_place:
        offsets = device.upload("offsets", np.full(len(counts), UNTOUCHED, np.uint32))
    total = device.upload("total", np.array([UNTOUCHED], np.uint32))
    count = None if live is None else device.upload("live", np.array([live], np.uint32))
    timeline = Timeline()
    ExclusiveScan(device, source, offsets, total, live=count)(timeline)
    device.wait()
    return device.read(offsets), int(device.read(total)[0])


def expected(counts):
    counts = np.asarray(counts, np.uint32)
    sums = np.zeros(len(counts) + 1, np.uint32)
    np.cumsum(counts, dtype=np.uint32, out=sums[1:])  # modulo 2^32, like the kernel
    return sums[:-1], int(sums[-1])


def assert_scanned(device, counts, **options):
    offsets, total = scan(device, counts, **options)
    wanted, wanted_total = expected(counts)
    np.testing.assert_array_equal(offsets, wanted)
    assert total == wanted_total


@pytest.mark.parametrize(
    "size",
    [0, 1, 2, 7, 8, 9, 15, 16, 17, 63, 64, 65, 511, 512, 513]
    + [k * CHUNK_ROWS + d for k in (1, 2, 3, 8) for d in (-1, 0, 1)],
)
def test_scan_equals_cumulative_sum_around_chunk_edges(device, size):
    assert_scanned(device, np.random.default_rng(size).integers(0, 1000, size))


@settings(max_examples=40, deadline=None)
@given(size=st.integers(0, 100_000), seed=st.integers(0, 2**32 - 1), high=st.integers(1, 2**32))
def test_scan_equals_cumulative_sum_modulo_2_to_32(device, size, seed, high):
    counts = np.random.default_rng(seed).integers(0, high, size, dtype=np.uint64)
    assert_scanned(device, counts)


def test_scan_of_2_to_26_rows(device):
    period = np.random.default_rng(26).integers(0, 64, 1009, dtype=np.uint32)
    assert_scanned(device, np.resize(period, 1 << 26))


def test_scan_in_place(device):
    assert_scanned(device, np.arange(20_011) % 5, in_place=True)


@pytest.mark.parametrize("live", [0, 1, 16, 4096, 12_345, 19_999])
def test_scan_stops_at_the_live_count_kept_on_the_device(device, live):
    counts = np.arange(20_000) % 7
    offsets, total = scan(device, counts, live=live)
    wanted, wanted_total = expected(counts[:live])
    np.testing.assert_array_equal(offsets[:live], wanted)
    assert (offsets[live:] == UNTOUCHED).all()
    assert total == wanted_total


def test_scan_takes_no_more_than_its_capacity(device):
    offsets, total = scan(device, np.ones(100), live=2**32 - 1)
    np.testing.assert_array_equal(offsets, np.arange(100))
    assert total == 100


@pytest.mark.parametrize("local_size", [1, 7, 256])
def test_scan_does_not_depend_on_the_work_group_size_or_on_the_cores(device, local_size):
    counts = np.random.default_rng(3).integers(0, 50, 70_001)
    other = Device.open(local_size=local_size, one_core=True)
    assert other.facts.compute_units == 1
    assert chunk_count(other, len(counts)) <= chunk_count(device, len(counts))
    assert_scanned(other, counts)


def test_scan_counts_towards_its_stage_and_reports_its_scratch(device):
    counts = device.upload("counts", np.ones(50_000, np.uint32))
    total = device.allocate("total", 1, np.uint32)
    scanned = ExclusiveScan(device, counts, counts, total, stage="geometry")
    timeline = Timeline()
    scanned(timeline)
    device.wait()
    assert list(timeline.collect().stage_s) == ["geometry"]
    assert scanned.scratch_bytes == 4 * chunk_count(device, 50_000)


def test_scan_may_run_again_on_new_counts(device):
    counts = device.upload("counts", np.ones(9000, np.uint32))
    offsets = device.allocate("offsets", 9000, np.uint32)
    total = device.allocate("total", 1, np.uint32)
    scanned = ExclusiveScan(device, counts, offsets, total)
    for value in (3, 5):
        device.fill(Timeline(), "clear", counts, value)
        scanned(Timeline())
        np.testing.assert_array_equal(device.read(offsets), value * np.arange(9000))
        assert device.read(total)[0] == value * 9000


def test_scan_refuses_another_type_or_a_short_buffer(device):
    floats = device.allocate("weights", 10, np.float32)
    signed = device.allocate("signed", 10, np.int32)
    counts = device.allocate("counts", 10, np.uint32)
    short = device.allocate("offsets", 9, np.uint32)
    total = device.allocate("total", 1, np.uint32)
    with pytest.raises(TypeError, match="weights: expected uint32, got float32"):
        ExclusiveScan(device, floats, counts, total)
    with pytest.raises(TypeError, match="signed: expected uint32, got int32"):
        ExclusiveScan(device, counts, signed, total)
    with pytest.raises(ValueError, match="offsets: expected at least 10 rows, got 9"):
        ExclusiveScan(device, counts, short, total)
