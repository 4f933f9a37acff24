import dataclasses
import json

import numpy as np
import pytest

from lodbench.harness.measure import limits as limits_module
from lodbench.harness.measure.limits import KERNELS, Rate, measure, measure_compaction, sweep
from lodbench.kernels.opencl.device import Device, Unsupported
from lodbench.kernels.opencl.timeline import Timeline
from lodbench.kernels.system import Traffic


@pytest.fixture(scope="module")
def limits(device):
    return measure(device, size_bytes=1 << 20, samples=10)


def test_limits_keep_every_sample_and_its_best_and_median(limits):
    for name in ("fill", "copy", "multiply_add", "launch_wall", "launch_event"):
        rate = getattr(limits, name)
        assert len(rate.samples) == 10
        assert rate.median == np.median(rate.samples)
        assert rate.best == (min if rate.unit == "s" else max)(rate.samples)
        assert 0 < rate.best < 1e15
    assert limits.launch_event.median <= limits.launch_wall.median
    assert limits.size_bytes == 1 << 20


def test_rates_count_bytes_written_bytes_read_and_written_and_two_operations(device, monkeypatch):
    # every call takes two seconds
    taken = ([2.0], [2.0])
    monkeypatch.setattr(
        limits_module, "timed", lambda _, subjects, __: dict.fromkeys(subjects, taken)
    )
    found = measure(device, size_bytes=1 << 20, samples=1, steps=10)
    assert (found.fill.median, found.copy.median) == (2**19, 2**20)
    items = device.facts.compute_units * limits_module.SWEEPS_ON_CPU if device.is_cpu else None
    assert items is None or found.multiply_add.median == 2 * 64 * 10 * items / 2
    assert (found.launch_wall.median, found.launch_event.median) == (2.0, 2.0)


def test_limits_are_plain_numbers_that_a_record_can_hold(limits):
    assert json.loads(json.dumps(dataclasses.asdict(limits)))["fill"]["unit"] == "B/s"


def test_limits_say_which_share_a_stage_reached(limits):
    bandwidth = max(limits.fill.median, limits.copy.median)
    exact = dataclasses.replace(
        limits,
        fill=Rate("driver", "B/s", 10.0, 10.0, (10.0,)),
        copy=Rate("driver", "B/s", 20.0, 20.0, (20.0,)),
        multiply_add=Rate("kernel", "flop/s", 100.0, 100.0, (100.0,)),
    )
    assert limits.share(Traffic(int(bandwidth)), 1.0) == pytest.approx(1.0, rel=1e-6)
    assert exact.least_s(Traffic(40)) == 2.0, "bytes at the faster of both bandwidths"
    assert exact.least_s(Traffic(40, 500)) == 5.0, (
        "arithmetic, where it takes longer than the bytes"
    )
    assert exact.share(Traffic(40), 8.0) == 0.25
    assert np.isnan(exact.share(Traffic(40), 0.0))


@pytest.mark.parametrize("count", [1, 2, 7, 8, 63, 1000, 4097])
@pytest.mark.parametrize("streaming", [False, True])
@pytest.mark.parametrize("is_cpu", [True, False])
def test_sweep_touches_every_vector_and_none_past_the_last(device, count, streaming, is_cpu):
    # the walk of a GPU, neighbouring items, is tried on whatever device the tests have
    other = Device(device.handle)
    other.is_cpu = is_cpu
    values = other.upload("values", np.zeros((count + 3, 8), np.float32))
    source = other.upload("source", np.random.default_rng(0).random((count, 8), np.float32))
    sweep(other, "fill", count, streaming=streaming, values=values, value=2.0)(Timeline())
    got = other.read(values)
    assert (got[:count] == 2.0).all()
    assert (got[count:] == 0.0).all()
    sweep(other, "copy", count, streaming=streaming, source=source, values=values)(Timeline())
    got = other.read(values)
    np.testing.assert_array_equal(got[:count], other.read(source))
    assert (got[count:] == 0.0).all()


def test_multiply_add_kernel_computes_its_chains(device):
    values = device.allocate("values", (5, 8), np.float32)
    program = device.build(KERNELS, defines={"STREAMING": 0})
    program.launch(
        "measure_limits_multiply_add", 5, stage="multiply_add",
        values=values, factor=0.5, term=1.0, steps=3, item_count=5,
    )(Timeline())  # fmt: skip
    # x -> x / 8 + 1.75 after three steps; eight chains start at i, i + 1, ... i + 7: 8 i + 28 in all
    expected = np.repeat((8 * np.arange(5) + 28) / 8 + 8 * 1.75, 8).reshape(5, 8)
    np.testing.assert_allclose(device.read(values), expected)


def test_measure_fits_a_small_device_and_refuses_one_without_room(device):
    small = measure(Device(device.handle, memory_limit=1 << 20), samples=1)
    assert small.size_bytes == 1 << 17
    with pytest.raises(Unsupported, match="values: needs 32 bytes"):
        measure(Device(device.handle, memory_limit=16), samples=1)


@pytest.mark.parametrize("rows", [0, 1, 10_000])
def test_compaction_is_measured_beside_a_copy(device, rows):
    rates = measure_compaction(device, rows, samples=2)
    assert set(rates) == {"scan", "compact", "compact_indices", "copy"}
    assert all(rate.best > 0 for rate in rates.values())


@pytest.mark.perf
@pytest.mark.parametrize("rows", [1 << 14, 1 << 20, 1 << 24])
def test_perf_scan_and_compaction(device, rows):
    for name, rate in measure_compaction(device, rows).items():
        print(f"{name:16s} {rows:9d} rows: {rate.median / 1e6:8.0f} Mrows/s")  # noqa: T201 - the report


@pytest.mark.perf
def test_perf_limits(device):
    measured = measure(device)
    for field in dataclasses.fields(measured):
        rate = getattr(measured, field.name)
        if isinstance(rate, Rate):
            print(f"{field.name:13s} {rate.median:10.4g} {rate.unit} ({rate.subject})")  # noqa: T201 - the report
