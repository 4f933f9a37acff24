"""Which OpenCL devices there are, and the one that a name means: the only file of the kernels that imports pyopencl."""

from __future__ import annotations

import os
import re
import shutil
import warnings
from typing import Any


class Unsupported(RuntimeError):
    """This device cannot do what was asked: "needs ..., device has ..."."""


class DeviceError(RuntimeError):
    """The driver refused or failed; the text says what to look at."""


def opencl() -> Any:
    """pyopencl, imported when a device is first wanted and never before."""
    pin_pocl_threads()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import pyopencl
    warnings.filterwarnings("ignore", category=pyopencl.CompilerWarning)
    return pyopencl


def pin_pocl_threads() -> None:
    """Have PoCL keep each of its threads on a core of its own, unless the environment says otherwise.

    A launch of a millisecond is over before the system has spread threads that share a core. PoCL pins thread i to core
    i, so nothing is said where this process may use some cores only, or PoCL was told to make fewer threads.
    """
    if not hasattr(os, "sched_getaffinity") or "POCL_MAX_PTHREAD_COUNT" in os.environ:
        return
    if os.sched_getaffinity(0) == set(range(os.cpu_count() or 0)):
        os.environ.setdefault("POCL_AFFINITY", "1")


def list_devices() -> list[tuple[str, str, str, Any]]:
    """("platform:device" index, platform name, device name, handle) of every device, in the loader's order."""
    cl = opencl()
    try:
        platforms = cl.get_platforms()
    except cl.Error:
        return []
    found = []
    for p, platform in enumerate(platforms):
        try:
            devices = platform.get_devices()
        except cl.Error:
            continue
        for d, device in enumerate(devices):
            found.append((f"{p}:{d}", platform.name.strip(), device.name.strip(), device))
    return found


def is_named(wanted: str, index: str, platform: str, device: str) -> bool:
    """Is the device the one at index `wanted` ("0:1"), or does its platform or name hold that text?"""
    if re.fullmatch(r"\d+:\d+", wanted):
        return wanted == index
    platform = platform.replace("Portable Computing Language", "PoCL, Portable Computing Language")
    return wanted.lower() in f"{platform} {device}".lower()


def choose_device(wanted: str) -> Any:
    """The handle of the first device that `wanted` names; for "" PoCL's, else the first there is.

    Raises:
        DeviceError: no driver, no such device, or no linker where the driver would end the process for want of it.
    """
    found = list_devices()
    if not found:
        raise DeviceError("device: expected an OpenCL driver, got none; run `lodbench doctor`")
    matches = [device for device in found if is_named(wanted or "pocl", *device[:3])]
    if wanted and not matches:
        labels = "; ".join(f"{index} {platform}: {name}" for index, platform, name, _ in found)
        raise DeviceError(f"device: expected one of [{labels}], got {wanted!r}")
    handle = (matches or found)[0][3]
    if "PoCL 3.0" in handle.platform.version and shutil.which("ld") is None:
        raise DeviceError(
            "device: expected the linker `ld` on PATH (PoCL calls it for every kernel and aborts without it), "
            "got none; install binutils"
        )
    return handle
