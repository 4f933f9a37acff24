import os
from types import SimpleNamespace

import pytest

from lodbench.kernels.opencl import driver
from lodbench.kernels.opencl.driver import DeviceError

POCL = "Portable Computing Language"


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


def test_pocl_threads_are_left_alone_where_the_system_cannot_pin(monkeypatch):
    monkeypatch.delenv("POCL_AFFINITY", raising=False)
    monkeypatch.delattr(driver.os, "sched_getaffinity", raising=False)
    driver.pin_pocl_threads()
    assert "POCL_AFFINITY" not in os.environ


@pytest.mark.parametrize(
    ("wanted", "index", "platform", "name", "expected"),
    [
        ("0:1", "0:1", "Intel", "cpu", True),
        ("0:1", "0:10", "Intel", "cpu", False),
        ("0:1", "1:0", "Intel 0:1", "cpu", False),  # an index is no part of a name
        ("intel cpu", "0:0", "Intel", "CPU", True),
        ("cpu", "0:0", "Intel", "CPU", True),
        ("pocl", "0:0", POCL, "cpu", True),
        ("portable", "0:0", POCL, "cpu", True),
        ("pocl", "0:0", "Intel", "cpu", False),
        ("pocl 3.1", "0:0", f"{POCL} 3.1+debian", "cpu", True),
        ("pocl 3.1", "0:0", f"{POCL} 3.0-rc2", "cpu", False),
        ("0:", "0:0", "Intel", "cpu", False),
        ("", "0:0", "Intel", "cpu", True),
    ],
)
def test_device_is_named_by_its_index_or_a_part_of_its_names(
    wanted, index, platform, name, expected
):
    assert driver.is_named(wanted, index, platform, name) is expected


@pytest.mark.parametrize(
    ("platform", "kind", "forced", "expected"),
    [
        ("PoCL 3.0", "CPU", None, True),
        ("PoCL 3.0", "GPU", None, False),
        ("Intel(R) OpenCL", "CPU", None, True),  # its mad, mix and rsqrt round otherwise
        ("Intel(R) OpenCL Graphics", "GPU", None, False),
        ("CUDA", "CPU", None, False),
        ("PoCL 3.0", "CPU", "0", False),
        ("CUDA", "GPU", "1", True),
        ("CUDA", "GPU", "yes", False),  # neither 0 nor 1 says nothing
        ("PoCL 3.0", "CPU", "", True),
    ],
)
def test_prelude_is_for_processors_unless_it_is_forced(
    monkeypatch, platform, kind, forced, expected
):
    monkeypatch.delenv("LODBENCH_PRELUDE", raising=False)
    if forced is not None:
        monkeypatch.setenv("LODBENCH_PRELUDE", forced)
    handle = SimpleNamespace(
        platform=SimpleNamespace(name=platform, version=f"OpenCL 1.2 {platform}"),
        type=getattr(driver.opencl().device_type, kind),
    )
    assert driver.needs_prelude(handle) is expected


@pytest.mark.parametrize("told", [None, "0"])
def test_driver_is_loaded_without_a_trace_in_the_environment(monkeypatch, told):
    monkeypatch.delenv("PYOPENCL_NO_CACHE", raising=False)
    if told is not None:
        monkeypatch.setenv("PYOPENCL_NO_CACHE", told)
    driver.opencl()
    assert os.environ.get("PYOPENCL_NO_CACHE") == told


def test_devices_are_listed_by_platform_and_place_and_a_platform_that_fails_is_left_out(
    monkeypatch,
):
    cl = driver.opencl()

    class Platform:
        def __init__(self, name, *devices):
            self.name, self.devices, self.version = name, devices, f"OpenCL 3.0 {name}"

        def get_devices(self):
            if not self.devices:
                raise cl.RuntimeError("clGetDeviceIDs", -1)
            return [SimpleNamespace(name=name) for name in self.devices]

    platforms = [Platform(" One ", "a ", "b"), Platform("Broken"), Platform("PoCL 3.1+x", "c")]
    monkeypatch.setattr(cl, "get_platforms", lambda: platforms)
    assert [found[:3] for found in driver.list_devices()] == [
        ("0:0", "One", "a"), ("0:1", "One", "b"), ("2:0", "PoCL 3.1+x 3.1+x", "c"),
    ]  # fmt: skip


def test_no_loader_means_no_devices(monkeypatch):
    cl = driver.opencl()

    def fail():
        raise cl.LogicError("clGetPlatformIDs", -1001)

    monkeypatch.setattr(cl, "get_platforms", fail)
    assert driver.list_devices() == []
