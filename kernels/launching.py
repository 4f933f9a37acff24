"""How a kernel that writes points and normals is built and launched: whole vectors in long rows on a CPU."""

from __future__ import annotations

from lodbench.kernels.opencl import Device

VERTEX_BYTES = 24  # a point and a normal, packed
LINE = 8  # vertices in a whole vector
CHUNK = {"cpu": 256}  # vertices of one work-item: rows of vectors on a CPU, one vector elsewhere
GROUP = {"cpu": 8}  # work-items of a group: few, since each has much to do; elsewhere the device's
STREAM_BYTES = 16 << 20  # a larger output leaves no cache warm: its stores go past them


def kernel_defines(device: Device, output_bytes: int) -> dict[str, int]:
    """The constants that such a kernel is built with on this device."""
    streaming = device.facts.kind == "cpu" and output_bytes > STREAM_BYTES
    return {"CHUNK": CHUNK.get(device.facts.kind, LINE), "STREAMING": int(streaming)}


def group_size(device: Device) -> int:
    """Work-items per group of such a kernel, at most the device's own number."""
    return min(GROUP.get(device.facts.kind, device.local_size), device.local_size)
