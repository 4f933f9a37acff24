"""The level-of-detail systems as OpenCL kernels, and a few calls that use them on arrays."""

# first: importing it later would put the package where the function `refine` stands
import lodbench.kernels.refine  # noqa: F401
from lodbench.kernels.api import (
    refine,
    refine_mesh,
    simplify,
    simplify_mesh,
    tessellate,
    tessellate_surface,
)
from lodbench.kernels.opencl import Device, DeviceError, Unsupported
from lodbench.kernels.render import render
from lodbench.kernels.result import Result
from lodbench.kernels.simplify_file import simplify_file
from lodbench.kernels.turntable import turntable

__all__ = [
    "Device", "DeviceError", "Result", "Unsupported",
    "simplify", "simplify_mesh", "simplify_file", "refine", "refine_mesh", "tessellate", "tessellate_surface",
    "render", "turntable",
]  # fmt: skip
