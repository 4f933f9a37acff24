import numpy as np
import pytest

from lodbench.kernels.opencl.device import Device
from lodbench.kernels.opencl.launch import Program
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


def test_launch_is_padded_to_whole_groups_in_each_dimension(device, tmp_path):
    file = tmp_path / "count.cl"
    file.write_text("__kernel void count_items(__global int *n) { atomic_inc(n); }")
    for items, local, run in [(5, 4, 8), ((5, 3), (4, 2), 32), ((5, 3), None, 64 * 3)]:
        total = device.upload("n", np.zeros(1, np.int32))
        launch = device.build(file).launch("count_items", items, stage="s", local=local, n=total)
        launch(Timeline())
        assert device.read(total)[0] == run
        assert launch.items == (items if isinstance(items, tuple) else (items,))


def test_launch_lists_its_parameters_in_the_source_s_order(device, program):
    launch = program.launch("shifted", 3, stage="vertex", **arguments(device))
    assert list(launch.parameters) == ["values", "sums", "scratch", "offset", "count"]


def test_launch_counts_towards_its_stage(device, program):
    timeline = Timeline()
    launch = program.launch("shifted", 3, stage="vertex", **arguments(device))
    event = launch(timeline)
    launch(timeline)
    device.wait()
    assert event.profile.end > event.profile.start
    once = (event.profile.end - event.profile.start) * 1e-9
    assert set(timeline.collect().stage_s) == {"vertex"}
    assert timeline.stage_s["vertex"] > once


def test_launch_refuses_an_unknown_argument_after_it_was_made(device, program):
    launch = program.launch("shifted", 3, stage="vertex", **arguments(device))
    with pytest.raises(TypeError, match=r"shifted: expected one of values, .*, got value"):
        launch.set(value=3)


def test_launch_takes_a_buffer_of_the_other_sign_and_a_view(device, program):
    given = arguments(device)
    bits = device.upload("bits", np.arange(3, dtype=np.float32).view(np.uint32))
    with pytest.raises(TypeError, match="values: expected float32, got bits of uint32"):
        program.launch("shifted", 3, stage="vertex", **given | {"values": bits})
    given["values"] = bits.view(3, np.float32)
    program.launch("shifted", 3, stage="vertex", **given)(Timeline())
    np.testing.assert_array_equal(device.read(given["sums"]), [1, 3, 5])


def test_launch_keeps_its_buffers_until_it_is_gone_or_gets_others(tmp_path):
    file = tmp_path / "kept.cl"
    file.write_text("__kernel void kept_add(__global int *n, const int3 by) { *n += by.y - by.z; }")
    small = Device.open(memory_limit=1000)
    launch = small.build(file).launch(
        "kept_add", 1, stage="s", local=1, n=small.upload("n", np.full(1, 5, np.int32)),
        by=(0, 9, 2),
    )  # fmt: skip
    assert small.used_bytes == 4
    other = small.upload("n", np.full(2, 7, np.uint32))  # the sign is the kernel's business
    launch.set(n=other)
    assert small.used_bytes == 8
    launch(Timeline())
    assert small.read(other).tolist() == [14, 7]
    del other
    assert small.used_bytes == 8
    del launch
    assert small.used_bytes == 0


def test_kernels_of_launches_that_are_gone_serve_again(device, program, monkeypatch):
    made = []
    make = Program._made
    monkeypatch.setattr(Program, "_made", lambda self, name: made.append(name) or make(self, name))
    program._spare["shifted"].clear()
    for _ in range(3):
        program.launch("shifted", 3, stage="x", **arguments(device))
    assert made == ["shifted"]
    together = [program.launch("shifted", 3, stage="x", **arguments(device)) for _ in range(3)]
    assert made == ["shifted"] * 3
    del together
    program.launch("shifted", 3, stage="x", **arguments(device))
    assert made == ["shifted"] * 3


def test_launch_runs_one_group_alone(device, program):
    given = arguments(device, count=150)
    launch = program.launch("shifted", 150, stage="vertex", local=64, **given)
    assert launch.groups == 3
    launch.group(Timeline(), 1)
    expected = np.zeros(150, np.float32)
    expected[64:128] = 2 * np.arange(64, 128) + 1
    np.testing.assert_array_equal(device.read(given["sums"]), expected)
