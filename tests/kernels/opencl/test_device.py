import numpy as np
import pytest

from lodbench.kernels.opencl import driver, source
from lodbench.kernels.opencl.device import Device, DeviceError, list_devices
from lodbench.kernels.opencl.timeline import Timeline


def test_device_without_a_driver_points_to_the_doctor(monkeypatch):
    monkeypatch.setattr(driver, "list_devices", lambda: [])
    with pytest.raises(DeviceError, match="run `lodbench doctor`"):
        Device.open()


def test_device_name_comes_from_the_environment(monkeypatch):
    monkeypatch.setenv("LODBENCH_DEVICE", "no such device")
    with pytest.raises(DeviceError, match="got 'no such device'"):
        Device.open()
    index, *_ = list_devices()[0]
    monkeypatch.setenv("LODBENCH_DEVICE", index)
    assert Device.open().facts.name == list_devices()[0][2]


def test_device_on_one_core_has_one_compute_unit_and_its_own_slug(device):
    single = Device.open(one_core=True)
    assert single.facts.compute_units == 1
    assert single.facts.one_core
    assert single.slug == device.slug + "-one-core"


def test_device_facts_are_filled(device):
    facts = device.facts
    assert facts.name and facts.platform and facts.driver
    assert facts.memory_bytes >= facts.largest_allocation_bytes > 0
    assert facts.compute_units >= 1
    assert facts.prelude == driver.needs_prelude(device.handle)


@pytest.mark.parametrize("forced", ["0", "1"])
def test_prelude_can_be_forced(monkeypatch, forced):
    monkeypatch.setenv("LODBENCH_PRELUDE", forced)
    assert Device.open().facts.prelude == (forced == "1")


def test_upload_checks_dtype_and_shape_by_name(device):
    values = np.zeros((4, 3))
    with pytest.raises(TypeError, match="positions: expected float32, got float64"):
        device.upload("positions", values, np.float32)
    with pytest.raises(ValueError, match=r"positions: expected shape \('n', 2\), got \(4, 3\)"):
        device.upload("positions", values, shape=(None, 2))
    with pytest.raises(ValueError, match=r"positions: expected shape \('n',\), got \(4, 3\)"):
        device.upload("positions", values, shape=(None,))


@pytest.mark.parametrize("dtype", ["u1", "i4", "u4", "i8", "f4", "f8"])
@pytest.mark.parametrize("shape", [(0,), (0, 3), (1,), (5, 3), (2, 3, 4)])
def test_upload_and_read_give_the_same_array(device, dtype, shape):
    values = np.arange(np.prod(shape)).reshape(shape).astype(dtype)
    got = device.read(device.upload("values", values))
    assert got.dtype == dtype
    np.testing.assert_array_equal(got, values)


def test_upload_takes_a_view_that_is_not_contiguous(device):
    values = np.arange(24, dtype=np.float32).reshape(6, 4)[::2, ::-1]
    np.testing.assert_array_equal(device.read(device.upload("values", values)), values)


def test_read_gives_the_first_rows(device):
    buffer = device.upload("values", np.arange(12, dtype=np.uint32).reshape(4, 3))
    np.testing.assert_array_equal(device.read(buffer, 2), [[0, 1, 2], [3, 4, 5]])
    assert device.read(buffer, 0).shape == (0, 3)


def test_fill_writes_the_whole_buffer_or_its_front(device):
    buffer = device.upload("values", np.zeros(10, np.uint32))
    timeline = Timeline()
    device.fill(timeline, "clear", buffer, 7)
    device.fill(timeline, "clear", buffer, 9, size_bytes=12)
    np.testing.assert_array_equal(device.read(buffer), [9] * 3 + [7] * 7)
    assert timeline.collect().stage_s["clear"] > 0
    device.fill(timeline, "clear", device.allocate("none", 0, np.uint32), 7)
    device.wait()


def test_copy_moves_to_the_front_of_the_target(device):
    source = device.upload("source", np.arange(3, dtype=np.uint32))
    target = device.upload("target", np.full(5, 9, np.uint32))
    device.copy(Timeline(), "copy", source, target)
    np.testing.assert_array_equal(device.read(target), [0, 1, 2, 9, 9])
    with pytest.raises(ValueError, match="source: expected 20 bytes, got 12"):
        device.copy(Timeline(), "copy", target, source)
    device.copy(Timeline(), "copy", device.allocate("none", 0, np.uint32), target)


@pytest.mark.parametrize("local_size", [1, 3, 64, 1 << 30])
def test_local_size_is_the_one_asked_for_at_most_the_device_s(local_size):
    opened = Device.open(local_size=local_size)
    assert opened.local_size == min(local_size, opened.handle.max_work_group_size)


def test_build_error_names_file_line_and_options(device, tmp_path):
    folder = tmp_path / "a folder with spaces"
    folder.mkdir()
    file = folder / "broken.cl"
    file.write_text("__kernel void broken(__global int *n)\n{\n    n[0] = missing;\n}\n")
    with pytest.raises(DeviceError) as error:
        device.build(file, defines={"WIDTH": 4, "STEP": 0.5})
    text = str(error.value)
    assert "broken.cl:3:12" in text
    assert "missing" in text
    assert "-D WIDTH=4" in text and "-D STEP=0.5f" in text


def test_build_error_in_a_needed_file_names_that_file(device, tmp_path, monkeypatch):
    monkeypatch.setattr(source, "KERNELS", tmp_path)
    monkeypatch.setattr(
        device, "facts", device.facts.__class__(**vars(device.facts) | {"prelude": False})
    )
    (tmp_path / "common").mkdir()
    (tmp_path / "common/part.cl").write_text("\n\nsyntax error here\n")
    (tmp_path / "whole.cl").write_text(
        "// Needs     common/part.cl\n__kernel void a(__global int *n) {}\n"
    )
    with pytest.raises(DeviceError, match=r"common/part\.cl:3:1"):
        device.build("whole.cl")


def test_program_is_built_once_per_set_of_defines(device):
    first = device.build("stages/compact.cl", defines={"ROW_WORDS": 1})
    assert device.build("stages/compact.cl", defines={"ROW_WORDS": 1}) is first
    assert device.build("stages/compact.cl", defines={"ROW_WORDS": 2}) is not first


def test_wait_reports_a_command_that_failed(device, monkeypatch):
    class Queue:
        def finish(self):
            raise device.cl.RuntimeError("clFinish", -5)

    monkeypatch.setattr(device, "_queue", Queue())
    with pytest.raises(DeviceError, match="a command failed on"):
        device.wait()
