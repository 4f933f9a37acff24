import os
from pathlib import Path

import pytest
from hypothesis import settings

from lodbench.kernels.device import Device, DeviceError

# the same examples in every run; `pytest --hypothesis-profile=search` looks for new ones
settings.register_profile("repeatable", derandomize=True)
settings.register_profile("search", derandomize=False)
settings.load_profile("repeatable")


@pytest.fixture(scope="session")
def device():
    """The default device, shared by all tests: opening one costs a second."""
    try:
        return Device.open()
    except DeviceError as error:
        pytest.fail(str(error))


@pytest.fixture(scope="session")
def data_folder():
    """The folder of real models, or a skip: everything must also work without it."""
    folder = os.environ.get("LODBENCH_DATA")
    if not folder or not Path(folder).is_dir():
        pytest.skip("LODBENCH_DATA is not set to a folder of real models")
    return Path(folder)
