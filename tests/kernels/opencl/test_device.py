import os
from types import SimpleNamespace

import numpy as np
import pytest

from lodbench.datasets_gen.triangles import icosphere
from lodbench.kernels import refine
from lodbench.kernels.opencl import driver, source
from lodbench.kernels.opencl.device import Device, DeviceError, Unsupported, list_devices
from lodbench.kernels.opencl.launch import kernel_parameters
from lodbench.kernels.opencl.memory import HELD_SHARE
from lodbench.kernels.opencl.timeline import Timeline

SOURCE = """// A kernel for the tests.
//
// Source    none
// Work      1-D, one item per value
// Reads     values  float[count]
// Writes    sums    float[count]
// Needs     {needed}
// Defines   SCALE

__kernel void shifted(
    __global const float *restrict values, // one per item
    __global float *restrict sums,
    __local float *scratch,
    const float4 offset,
    const uint count)
{{
    const uint i = get_global_id(0);
    if (i >= count) return;
    scratch[get_local_id(0)] = values[i];
    sums[i] = twice(scratch[get_local_id(0)] * SCALE) + offset.x + offset.y + offset.z + offset.w;
}}
"""


@pytest.fixture
def program(device, tmp_path):
    folder = tmp_path / "a folder with spaces"
    folder.mkdir()
    needed = folder / "twice.cl"
    needed.write_text("static inline float twice(const float x) { return x + x; }\n")
    file = folder / "shifted.cl"
    # a name with a space cannot stand on a `Needs` line, and none inside kernels/ has one
    file.write_text(SOURCE.format(needed="common/chunk.cl"))
    return device.build(needed, file, defines={"SCALE": 1.0})


def arguments(device, count=3):
    return {
        "values": device.upload("values", np.arange(count, dtype=np.float32)),
        "sums": device.upload("sums", np.zeros(count, np.float32)),
        "scratch": 4 * 64,
        "offset": (1, 0, 0, 0),
        "count": count,
    }


class FakeHandle:
    """As much of a driver's device as choosing looks at."""

    def __init__(self, name, version):
        self.name = name
        self.platform = SimpleNamespace(version=version)


@pytest.fixture
def loader(monkeypatch):
    """Three made-up devices; returns a chooser that gives the name of the handle."""
    found = [
        ("0:0", "NVIDIA CUDA", "NVIDIA H100", FakeHandle("h100", "OpenCL 3.0 CUDA")),
        ("0:1", "NVIDIA CUDA", "NVIDIA T4", FakeHandle("t4", "OpenCL 3.0 CUDA")),
        ("1:0", "Portable Computing Language", "pthread-epyc", FakeHandle("epyc", "PoCL 3.0-rc2")),
    ]
    monkeypatch.setattr(driver, "list_devices", lambda: found)
    monkeypatch.setattr(driver.shutil, "which", lambda name: f"/usr/bin/{name}")
    return lambda wanted: driver.choose_device(wanted).name


@pytest.mark.parametrize(
    ("wanted", "handle"),
    [
        ("", "epyc"), ("pocl", "epyc"), ("PoCL", "epyc"), ("portable", "epyc"), ("EPYC", "epyc"),
        ("nvidia", "h100"), ("t4", "t4"), ("0:1", "t4"), ("0:0", "h100"), ("1:0", "epyc"),
    ],
)  # fmt: skip
def test_device_is_chosen_by_name_or_index(loader, wanted, handle):
    assert loader(wanted) == handle


@pytest.mark.parametrize("wanted", ["amd", "2:0", "0:7", "1:00"])
def test_device_that_does_not_exist_is_refused_with_those_that_do(loader, wanted):
    with pytest.raises(DeviceError, match="0:1 NVIDIA CUDA: NVIDIA T4") as error:
        loader(wanted)
    assert str(error.value).endswith(f"got {wanted!r}")


def test_device_falls_back_on_the_first_where_there_is_no_pocl(monkeypatch):
    handle = FakeHandle("cpu", "OpenCL 3.1")
    monkeypatch.setattr(driver, "list_devices", lambda: [("0:0", "Intel", "CPU", handle)])
    assert driver.choose_device("") is handle


def test_pocl_without_a_linker_is_an_error_and_not_an_abort(loader, monkeypatch):
    monkeypatch.setattr(driver.shutil, "which", lambda name: None)
    with pytest.raises(DeviceError, match="install binutils"):
        loader("pocl")
    assert loader("nvidia") == "h100", "other drivers do not need it"


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
    assert facts.prelude == (device.is_pocl and device.is_cpu)


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


def test_memory_limit_refuses_with_the_bytes_needed_and_free():
    small = Device.open(memory_limit=1000)
    held = small.allocate("held", 150, np.float32)
    with pytest.raises(Unsupported, match=r"more: needs 4,000 bytes .* device has 400 \(free\)"):
        small.allocate("more", 1000, np.float32)
    assert small.used_bytes == 600
    held.release()
    assert small.used_bytes == 0
    assert small.allocate("again", 250, np.float32).size_bytes == 1000


def test_allocation_over_the_device_limit_is_unsupported(device):
    count = device.facts.largest_allocation_bytes // 4 + 1
    with pytest.raises(Unsupported, match="bytes of device memory, device has"):
        device.allocate("huge", count, np.float32)


def test_memory_comes_back_when_a_buffer_is_dropped():
    small = Device.open(memory_limit=1000)
    for _ in range(5):
        buffer = small.allocate("values", 200, np.float32)
        del buffer
    assert small.used_bytes == 0


def test_released_buffer_is_released_once():
    small = Device.open(memory_limit=1000)
    buffer = small.allocate("values", 10, np.float32)
    buffer.release()
    buffer.release()
    assert small.used_bytes == 0


def test_pool_hands_the_same_memory_out_again(device):
    buffer = device.allocate("values", 1 << 20, np.float32)
    handle = buffer.memory.int_ptr
    buffer.release()
    assert device.allocate("other", 1 << 20, np.float32).memory.int_ptr == handle


def test_buffers_of_many_sizes_leave_a_bounded_amount_held():
    small = Device.open(memory_limit=1 << 20)
    bound, most = HELD_SHARE * small.memory_limit, 0
    for k in range(1, 60):
        buffers = [small.allocate("values", 97 * k * n, np.float32) for n in (1, 3, 7)]
        small.fill(Timeline(), "fill", buffers[-1], 0)
        del buffers
        assert small.used_bytes == 0
        assert small.held_bytes <= bound
        most = max(most, small.held_bytes)
    assert most > bound / 2, "what is within the bound is kept"


def test_calls_of_many_sizes_leave_a_bounded_amount_held():
    small = Device.open(memory_limit=4 << 20)
    for segments in range(2, 40, 3):
        refine(icosphere(1), segments=segments, device=small)
        assert small.used_bytes == 0
        assert small.held_bytes <= HELD_SHARE * small.memory_limit


def test_view_reads_the_same_memory_as_another_type():
    small = Device.open(memory_limit=1000)
    buffer = small.upload("values", np.array([[1.0, 2.0]], np.float32))
    view = buffer.view(2, np.uint32)
    np.testing.assert_array_equal(small.read(view), [0x3F800000, 0x40000000])
    with pytest.raises(ValueError, match="values: expected a view of at most 8 bytes, got 12"):
        buffer.view(3, np.uint32)
    del buffer
    assert small.used_bytes == 8, "the view keeps the memory"
    del view
    assert small.used_bytes == 0


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


def test_kernel_runs_with_local_memory_vectors_and_defines(device, program):
    given = arguments(device)
    program.launch("shifted", 3, stage="vertex", **given)(Timeline())
    np.testing.assert_array_equal(device.read(given["sums"]), [1, 3, 5])


def test_launch_sets_new_arguments_and_items(device, program):
    given = arguments(device, count=130)
    launch = program.launch("shifted", 1, stage="vertex", **given)
    launch.items = 130
    launch.set(offset=(1, 1, 1, 1))
    launch(Timeline())
    np.testing.assert_array_equal(device.read(given["sums"]), 2 * np.arange(130) + 4)


@pytest.mark.parametrize(
    ("change", "error", "text"),
    [
        ({"count": None}, TypeError, r"shifted: expected arguments \['count'\]"),
        ({"colour": 1}, TypeError, "shifted: expected one of values, .*, got colour"),
        ({"count": -1}, ValueError, "shifted: count: expected 0 to 4294967295, got -1"),
        ({"count": 1 << 32}, ValueError, "shifted: count: expected 0 to 4294967295"),
        ({"values": 3}, TypeError, "shifted: values: expected a Buffer, got int"),
        ({"values": "u4"}, TypeError, "shifted: values: expected float32, got given of uint32"),
        ({"values": "f8"}, TypeError, "shifted: values: expected float32, got given of float64"),
    ],
)
def test_launch_checks_its_arguments_by_name(device, program, change, error, text):
    given = arguments(device)
    for name, value in change.items():
        if value is None:
            del given[name]
        elif isinstance(value, str):
            given[name] = device.allocate("given", 3, value)
        else:
            given[name] = value
    with pytest.raises(error, match=text):
        program.launch("shifted", 3, stage="vertex", **given)


def test_launches_that_live_together_keep_their_own_arguments(device, program):
    launches = []
    for number in range(3):  # the first is gone before the second is made, and lends it its kernel
        given = arguments(device) | {"offset": (number, 0, 0, 0)}
        launches.append((program.launch("shifted", 3, stage="x", **given), given["sums"]))
        launches = launches[-1:] if number == 1 else launches
    launches[0][0](Timeline())
    program.launch("shifted", 3, stage="x", **arguments(device))(Timeline())  # gone before it runs
    launches[1][0](Timeline())
    assert [device.read(sums).tolist() for _, sums in launches] == [[1, 3, 5], [2, 4, 6]]


def test_launch_refuses_an_unknown_kernel(device, program):
    with pytest.raises(ValueError, match="kernel: expected one of shifted, got other"):
        program.launch("other", 1, stage="vertex")


def test_launch_of_no_items_is_padded_and_harmless(device, program):
    given = arguments(device) | {"count": 0}
    program.launch("shifted", 0, stage="vertex", **given)(Timeline())
    np.testing.assert_array_equal(device.read(given["sums"]), [0, 0, 0])


@pytest.mark.parametrize("local_size", [1, 3, 64, 1 << 30])
def test_local_size_is_the_one_asked_for_at_most_the_device_s(local_size):
    opened = Device.open(local_size=local_size)
    assert opened.local_size == min(local_size, opened.handle.max_work_group_size)


def test_launch_is_padded_to_whole_groups_in_each_dimension(device, tmp_path):
    file = tmp_path / "count.cl"
    file.write_text("__kernel void count_items(__global int *n) { atomic_inc(n); }")
    for items, local, run in [(5, 4, 8), ((5, 3), (4, 2), 32), ((5, 3), None, 64 * 3)]:
        total = device.upload("n", np.zeros(1, np.int32))
        launch = device.build(file).launch("count_items", items, stage="s", local=local, n=total)
        launch(Timeline())
        assert device.read(total)[0] == run
        assert launch.items == (items if isinstance(items, tuple) else (items,))


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


def test_needed_files_are_joined_once_and_before_those_that_need_them(
    device, tmp_path, monkeypatch
):
    monkeypatch.setattr(source, "KERNELS", tmp_path)
    monkeypatch.setattr(
        device, "facts", device.facts.__class__(**vars(device.facts) | {"prelude": False})
    )
    (tmp_path / "a.cl").write_text("static int a() { return 1; }\n")
    (tmp_path / "b.cl").write_text("// Needs     a.cl\nstatic int b() { return a() + 1; }\n")
    (tmp_path / "c.cl").write_text(
        "// Needs     b.cl, a.cl\n__kernel void c(__global int *n) { n[0] = a() + 10 * b(); }\n"
    )
    number = device.upload("n", np.zeros(1, np.int32))
    device.build("c.cl").launch("c", 1, stage="s", n=number)(Timeline())
    assert device.read(number)[0] == 21


def test_program_is_built_once_per_set_of_defines(device):
    first = device.build("stages/compact.cl", defines={"ROW_WORDS": 1})
    assert device.build("stages/compact.cl", defines={"ROW_WORDS": 1}) is first
    assert device.build("stages/compact.cl", defines={"ROW_WORDS": 2}) is not first


def test_kernel_parameters_are_read_from_the_source():
    source = """
        /* __kernel void not_this(int a) */
        __kernel __attribute__((reqd_work_group_size(64, 1, 1)))
        void first(__global const float4 *restrict positions, // (a comment, with a comma)
                   __constant uint *table, __local ulong *scratch,
                   const uint2 size, const int sign, __global uchar *flags)
        {
        }
        // __kernel void nor_this(int a)
        __kernel void second(const double value) {}
    """
    found = kernel_parameters(source)
    assert list(found) == ["first", "second"]
    described = [(p.name, p.space, p.scalar.name, p.lanes) for p in found["first"]]
    assert described == [
        ("positions", "global", "float32", 4),
        ("table", "constant", "uint32", 1),
        ("scratch", "local", "uint64", 1),
        ("size", "", "uint32", 2),
        ("sign", "", "int32", 1),
        ("flags", "global", "uint8", 1),
    ]
    assert [(p.space, p.scalar.name) for p in found["second"]] == [("", "float64")]


def test_kernel_parameters_refuse_a_type_of_one_s_own():
    with pytest.raises(ValueError, match="odd: expected a built-in scalar or vector type"):
        kernel_parameters("__kernel void odd(__global struct node *nodes) {}")


def test_wait_reports_a_command_that_failed(device, monkeypatch):
    class Queue:
        def finish(self):
            raise device.cl.RuntimeError("clFinish", -5)

    monkeypatch.setattr(device, "_queue", Queue())
    with pytest.raises(DeviceError, match="a command failed on"):
        device.wait()


@pytest.mark.parametrize(
    ("usable", "told", "expected"),
    [
        ({0, 1, 2}, {}, "1"),
        ({0, 1, 2}, {"POCL_AFFINITY": "0"}, "0"),
        ({0, 1, 2}, {"POCL_MAX_PTHREAD_COUNT": "2"}, None),
        ({0, 2}, {}, None),  # thread 1 would sit on a core that is not ours
    ],
)
def test_pocl_threads_are_pinned_where_every_core_is_ours(monkeypatch, usable, told, expected):
    for name in ("POCL_AFFINITY", "POCL_MAX_PTHREAD_COUNT"):
        monkeypatch.delenv(name, raising=False)
    for name, value in told.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(driver.os, "cpu_count", lambda: 3)
    monkeypatch.setattr(driver.os, "sched_getaffinity", lambda _: usable, raising=False)
    driver.pin_pocl_threads()
    assert os.environ.get("POCL_AFFINITY") == expected
