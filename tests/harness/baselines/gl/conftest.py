import pytest

from lodbench.harness.baselines.gl.driver import context
from lodbench.kernels.opencl.device import Unsupported


@pytest.fixture(scope="session")
def gl():
    """The OpenGL context, or a skip with the reason."""
    try:
        return context()
    except Unsupported as reason:
        pytest.skip(str(reason))
