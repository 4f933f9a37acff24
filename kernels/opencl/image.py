"""Pictures of four floats a texel that kernels read through a sampler: texture memory, where a device has any."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lodbench.datasets_gen.surfaces import Floats
from lodbench.kernels.opencl.driver import Unsupported
from lodbench.kernels.opencl.memory import Buffer

if TYPE_CHECKING:
    from lodbench.kernels.opencl.device import Device


class Image(Buffer):
    """A buffer that is an `image2d_t` to a kernel; not out of the device's pool, and not within its limit."""


def upload_image(device: Device, name: str, texels: Floats) -> Image:
    """An image of (h, w, 4) float32 texels, for kernels to read.

    Raises:
        TypeError, ValueError: another dtype or shape.
        Unsupported: the device has no images, or none so large.
    """
    texels = np.ascontiguousarray(texels)
    if texels.dtype != np.float32:
        raise TypeError(f"{name}: expected float32, got {texels.dtype}")
    if texels.ndim != 3 or texels.shape[2] != 4 or not texels.size:
        raise ValueError(f"{name}: expected shape (h, w, 4), got {texels.shape}")
    cl, (height, width) = device.cl, texels.shape[:2]
    handle = device.handle
    if not handle.image_support:
        raise Unsupported(f"{name}: needs images, device has none")
    if height > handle.image2d_max_height or width > handle.image2d_max_width:
        most = f"{handle.image2d_max_width} x {handle.image2d_max_height}"
        raise Unsupported(f"{name}: needs {width} x {height} texels, device has {most}")
    flags = cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR
    form = cl.ImageFormat(cl.channel_order.RGBA, cl.channel_type.FLOAT)
    memory = cl.create_image(device.context, flags, form, shape=(width, height), hostbuf=texels)
    return Image(name, texels.shape, texels.dtype, memory, lambda size: None)
