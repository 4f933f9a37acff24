import numpy as np
import pytest

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.device_fill import SYSTEM, Params
from lodbench.kernels.opencl.device import Device, Unsupported
from lodbench.kernels.system import run

TRIANGLE = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])


@pytest.mark.parametrize("by", ["driver", "kernel", "streaming"])
@pytest.mark.parametrize("size_bytes", [0, 1, 32, 100, 100_000])
def test_device_fill_writes_every_byte(device, by, size_bytes):
    prepared = SYSTEM.prepare(device, TRIANGLE, Params(size_bytes=size_bytes, by=by))
    timeline = run(device, prepared)
    assert prepared.check().passed
    written = prepared.counters()["bytes"]
    assert size_bytes <= written < size_bytes + 32
    assert prepared.footprint().output_bytes == written
    assert set(prepared.traffic()) <= set(timeline.stage_s)


def test_device_fill_takes_the_bytes_of_the_refined_mesh(device):
    prepared = SYSTEM.prepare(device, TRIANGLE, Params(segments=3))
    # 10 vertices of 24 bytes are 240, 8 vectors of 32 bytes
    assert prepared.counters()["bytes"] == 256


def test_device_fill_check_sees_a_word_that_was_not_filled(device):
    prepared = SYSTEM.prepare(device, TRIANGLE, Params(size_bytes=64))
    device.cl.enqueue_copy(device.queue, prepared._values.memory, np.zeros(1, np.float32))
    assert prepared.check().value == 1
    assert not prepared.check().passed


def test_device_fill_refuses_bad_params_and_too_much(device):
    with pytest.raises(ValueError, match="size_bytes: expected at least 0, got -1"):
        Params(size_bytes=-1)
    with pytest.raises(ValueError, match="segments: expected 1 to 4096, got 0"):
        Params(segments=0)
    with pytest.raises(
        ValueError, match="by: expected one of driver, kernel, streaming, got 'hand'"
    ):
        Params(by="hand")
    with pytest.raises(Unsupported, match="size_bytes: needs a number for BezierPatches, got None"):
        SYSTEM.prepare(device, catalogue.load("pot_32").surface, Params())
    with pytest.raises(Unsupported, match="values: needs 4,096 bytes"):
        SYSTEM.prepare(Device(device.handle, memory_limit=100), TRIANGLE, Params(size_bytes=4096))
