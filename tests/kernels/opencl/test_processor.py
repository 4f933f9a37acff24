import ctypes
import sys
from types import SimpleNamespace

import pytest

from lodbench.kernels.opencl.processor import explained, name_for, name_unknown

NEW = "flags\t\t: fpu avx2 fma bmi2 f16c abm movbe sse4a avx512f"
VERSION = "OpenCL 3.0 PoCL HSTR: pthread-x86_64-unknown-linux-gnu-generic"
linux = pytest.mark.skipif(sys.platform != "linux", reason="reads this process's memory by /proc")


def record(name=b"generic", version=VERSION):
    """A device's handle, as far as it is looked at, and the text that stands for its processor."""
    target, place = (
        ctypes.create_string_buffer(text, 24) for text in (b"x86_64-unknown-linux-gnu"[:23], name)
    )
    words = (ctypes.c_uint64 * 512)()
    words[3], words[5] = 1, 2**63  # no addresses
    words[79], words[80] = ctypes.addressof(target), ctypes.addressof(place)
    handle = SimpleNamespace(
        version=version, int_ptr=ctypes.addressof(words), held=(words, target, place)
    )
    return handle, place


@pytest.mark.parametrize(
    ("cpuinfo", "name"),
    [
        (f"vendor_id\t: AuthenticAMD\n{NEW} avx512bw avx512cd avx512dq avx512vl\n", "skx"),
        (f"vendor_id\t: AuthenticAMD\n{NEW}\n", "znver3"),
        (f"vendor_id\t: GenuineIntel\n{NEW}\n", "haswell"),
        ("vendor_id\t: AuthenticAMD\nflags\t\t: fpu sse2 avx2\n", "x86-64"),
        ("", "x86-64"),
    ],
)
def test_name_is_the_newest_whose_code_the_processor_runs(cpuinfo, name):
    assert name_for(cpuinfo) == name


@linux
def test_unknown_processor_gets_a_known_name_once():
    handle, place = record()
    name = name_unknown(handle)
    assert name in ("skx", "znver3", "haswell", "x86-64")
    assert place.value == name.encode()
    assert name_unknown(handle) == name
    assert place.value == name.encode()


@linux
@pytest.mark.parametrize(
    "unlike", [{"name": b"znver2"}, {"version": "OpenCL 3.0 PoCL HSTR: pthread-x86_64-unknown-linux-gnu-znver2"}]
)  # fmt: skip
def test_known_processor_is_left_alone(unlike):
    handle, place = record(**unlike)
    before = place.raw
    assert name_unknown(handle) == ""
    assert place.raw == before


def test_failed_build_says_what_an_unknown_processor_means():
    assert explained("a.cl:3:1: error: expected ';'") == "a.cl:3:1: error: expected ';'"
    text = explained("error: unknown target CPU 'generic'")
    assert (
        text.startswith("error: unknown target CPU 'generic'\n") and "another OpenCL driver" in text
    )


def test_device_says_which_processor_it_compiles_for(device):
    assert (device.facts.compiles_for != "") == device.handle.version.endswith("-generic")
