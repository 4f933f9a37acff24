"""What happens where there is no OpenGL driver; needs none."""

import sys

import pytest

from lodbench.harness.baselines.gl import driver
from lodbench.kernels.opencl.device import Unsupported


def test_context_without_moderngl_is_unsupported_with_the_reason(monkeypatch):
    driver._context.cache_clear()
    monkeypatch.setitem(sys.modules, "moderngl", None)
    with pytest.raises(Unsupported, match="needs moderngl, this environment has none"):
        driver.context()
    driver._context.cache_clear()


def test_context_without_a_driver_is_unsupported_with_the_reason(monkeypatch):
    moderngl = pytest.importorskip("moderngl")

    def fail(**settings):
        raise RuntimeError("libEGL.so.1: cannot open shared object file")

    driver._context.cache_clear()
    monkeypatch.setattr(moderngl, "create_standalone_context", fail)
    with pytest.raises(Unsupported, match=r"OpenGL 3\.3 driver through EGL .* libEGL\.so\.1"):
        driver.context()
    driver._context.cache_clear()
