"""OpenCL as the rest of the project sees it: a device, its memory, launches of its kernels, and where the time goes."""

from lodbench.kernels.opencl.device import Device
from lodbench.kernels.opencl.driver import DeviceError, Unsupported
from lodbench.kernels.opencl.launch import Launch, Program
from lodbench.kernels.opencl.memory import Buffer
from lodbench.kernels.opencl.source import Text
from lodbench.kernels.opencl.timeline import Timeline

__all__ = [
    "Buffer", "Device", "DeviceError", "Launch", "Program", "Text", "Timeline", "Unsupported",
]  # fmt: skip
