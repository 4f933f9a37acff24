"""A user's text among the kernel files: joined in its place, and blamed for a build in the words of its argument."""

import numpy as np
import pytest

from lodbench.kernels.opencl import Device, DeviceError, Text
from lodbench.kernels.opencl.source import texts_of
from lodbench.kernels.opencl.timeline import Timeline

CALL = "static inline float called(const float x) {\n    return own(x);\n}\n"
KERNEL = "__kernel void k(__global float *o) { o[get_global_id(0)] = called(1.0f); }\n"


def text(code):
    return Text("own", code, CALL, "float own(float x)")


@pytest.fixture
def kernel(tmp_path):
    path = tmp_path / "k.cl"
    path.write_text(KERNEL)
    return path


def built(device, kernel, code):
    made = device.allocate("o", 1, np.float32)
    device.build(text(code), kernel).launch("k", 1, stage="s", local=1, o=made)(Timeline())
    return device.read(made)[0]


def test_text_stands_where_it_is_named_with_its_call_behind_it(kernel):
    assert list(texts_of([text("x"), kernel])) == ["own", "own's call", str(kernel)]


@pytest.mark.parametrize(
    "code",
    [
        "float own(float x) { return x + 2; }",
        "// größer \u20ac\nfloat own(float x) { return x + 2; } // \\",
        "__kernel void other(__global struct node *n) {}\nstatic inline float own(float x) { return x + 2; }",
    ],
)
def test_text_is_built_among_the_kernels(device, kernel, code):
    assert built(device, kernel, code) == 3


def test_texts_are_built_once_each(device, kernel):
    one, again, other = (
        device.build(text(f"float own(float x) {{ return {n}; }}"), kernel) for n in (4, 4, 5)
    )
    assert one is again and one is not other


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("\n\nfloat own(float x) { return foo; }", "C that builds, line 3: use of undeclared identifier 'foo'"),
        ("#include </none.h>", "line 1: '/none.h' file not found"),
        ("float own(float x) { return 1;", "behind it, as where a bracket is left open"),
        ("float own(float x) { return (1;\n}", "line 1: expected"),
        ("/* own", "line 1: unterminated"),
        ("void own(float x) {}", "float own[(]float x[)], got another"),
        ("float own(float x, float y) { return 1; }", "float own[(]float x[)], got another"),
        ("float g(float);\nfloat own(float x) { return g(x); }", "a definition of g, got none"),
    ],
)  # fmt: skip
def test_build_error_names_argument_and_line(device, kernel, code, said):
    with pytest.raises(ValueError, match=f"^own: expected .*{said}") as found:
        built(device, kernel, code)
    assert "\n" not in str(found.value)


def test_error_of_another_compiler_is_read_too():
    log = "warning: here\nown:7:3: fatal error: 'x.h' file not found\n1 error generated."
    assert (
        text("").blamed(log) == "own: expected OpenCL C that builds, line 7: 'x.h' file not found"
    )
    assert text("").blamed("clBuildProgram failed: out of memory") == ""


def test_build_that_fails_for_another_reason_stays_a_device_error(device, kernel, monkeypatch):
    def failing(*_):
        raise DeviceError("the disk is full")

    monkeypatch.setattr(Device, "compile", failing)
    with pytest.raises(DeviceError, match="disk"):
        built(device, kernel, "float own(float x) { return 9; }")
