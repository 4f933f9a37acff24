import numpy as np
import pytest

from lodbench.kernels.opencl import Device, DeviceError, Timeline, binaries

TEXT = "__kernel void double_it(__global float *restrict a) { a[get_global_id(0)] *= 2.0f; }"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("LODBENCH_CACHE", str(tmp_path))
    return tmp_path / "programs"


def doubled(file):
    """What a device of a driver that keeps no programs makes of ones."""
    device = Device.open()
    values = device.upload("a", np.ones(64, np.float32))
    device.build(file).launch("double_it", 64, stage="double", a=values)(Timeline())
    return device.read(values)


@pytest.fixture
def kernel(tmp_path, monkeypatch):
    monkeypatch.setattr(binaries, "KEEPS_NONE", "")
    path = tmp_path / "double_it.cl"
    path.write_text(TEXT)
    return path


def test_program_is_built_once_and_then_found(folder, kernel, monkeypatch):
    assert (doubled(kernel) == 2).all()
    (kept,) = folder.iterdir()
    before = kept.stat().st_mtime_ns
    monkeypatch.setattr(binaries, "keep", lambda path, binary: pytest.fail("built again"))
    assert (doubled(kernel) == 2).all()
    assert kept.stat().st_mtime_ns == before


@pytest.mark.parametrize(
    "harm", [lambda data: data[:-5], lambda data: b"", lambda data: data[::-1]]
)
def test_damaged_file_is_built_again(folder, kernel, harm):
    doubled(kernel)
    (kept,) = folder.iterdir()
    whole = kept.read_bytes()
    kept.write_bytes(harm(whole))
    assert binaries.load(kept) is None
    assert (doubled(kernel) == 2).all()
    assert binaries.load(kept) is not None


def test_binary_that_the_driver_refuses_is_built_again(folder, kernel):
    doubled(kernel)
    (kept,) = folder.iterdir()
    binaries.keep(kept, b"of another driver")
    assert (doubled(kernel) == 2).all()


def test_folder_that_cannot_be_written_is_done_without(folder, kernel):
    folder.write_text("a file in its place")
    assert (doubled(kernel) == 2).all()


def test_failed_build_is_told_as_ever(folder, kernel):
    kernel.write_text(TEXT.replace("2.0f", "two"))
    with pytest.raises(DeviceError, match="double_it"):
        Device.open().build(kernel)
    assert not folder.exists()


def test_name_comes_of_all_that_a_binary_depends_on():
    assert binaries.path_of("a", "b") == binaries.path_of("a", "b")
    assert len({binaries.path_of(*words) for words in (("a", "b"), ("ab",), ("b", "a"))}) == 3
