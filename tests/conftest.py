import os
import shutil
import tempfile
from pathlib import Path

import pytest
from hypothesis import settings

from lodbench.kernels.opencl.device import Device, DeviceError
from tests import tally

# the same examples in every run; `pytest --hypothesis-profile=search` looks for new ones
settings.register_profile("repeatable", derandomize=True)
settings.register_profile("search", derandomize=False)
settings.load_profile("repeatable")


def pytest_addoption(parser):
    parser.addoption("--tally", type=Path, help="note in this file how many passed on the device")


def pytest_terminal_summary(terminalreporter, config):
    if config.getoption("--tally"):
        tally.write(config.getoption("--tally"), terminalreporter)


def pytest_configure(config):
    """One cache folder per test run, which its processes share: what is made once is found by all, and left by none."""
    if "LODBENCH_TEST_CACHE" not in os.environ:
        folder = tempfile.mkdtemp(prefix="lodbench-tests-")
        os.environ["LODBENCH_TEST_CACHE"] = folder
        config.add_cleanup(lambda: shutil.rmtree(folder, ignore_errors=True))
    os.environ["LODBENCH_CACHE"] = os.environ["LODBENCH_TEST_CACHE"]


@pytest.fixture(scope="session")
def device():
    """The default device, shared by all tests: opening one costs a second."""
    try:
        return Device.open()
    except DeviceError as error:
        pytest.fail(str(error))


@pytest.fixture(scope="session")
def pocl(device):
    """The default device, or a skip where that is none of PoCL from pip: for tests of its linker and settings."""
    if not device.is_pocl or "LODBENCH_DEVICE" in os.environ:
        pytest.skip("of the ways of PoCL from pip, on another driver")
    return device


@pytest.fixture(scope="session")
def data_folder():
    """The folder of real models, or a skip: everything must also work without it."""
    folder = os.environ.get("LODBENCH_DATA")
    if not folder or not Path(folder).is_dir():
        pytest.skip("LODBENCH_DATA is not set to a folder of real models")
    return Path(folder)
