"""Which OpenCL devices there are, and the one that a name means: the only file of the kernels that imports pyopencl."""

from __future__ import annotations

import os
import re
import shutil
import signal
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from lodbench.kernels.opencl import caches

_loaded = (
    False  # has the driver started its threads, in this process or the one it was forked from?
)
_forked = False  # is this a child that was forked after that?


def _note_fork() -> None:
    global _forked
    _forked = _loaded


if hasattr(
    os, "register_at_fork"
):  # asking for the process's number at each call costs as much as a launch
    os.register_at_fork(after_in_child=_note_fork)


class Unsupported(RuntimeError):
    """This device cannot do what was asked: "needs ..., device has ..."."""


class DeviceError(RuntimeError):
    """The driver refused or failed; the text says what to look at."""


def opencl() -> Any:
    """pyopencl, imported when a device is first wanted and never before.

    It goes without its own cache: PoCL and NVIDIA's driver keep theirs, and what is left to it takes longer to read
    than to make. So there is one folder less that can be full, read-only or damaged.
    """
    pin_pocl_threads()
    with warnings.catch_warnings(), _environment("PYOPENCL_NO_CACHE", "1"):
        warnings.simplefilter("ignore")
        import pyopencl
    warnings.filterwarnings("ignore", category=pyopencl.CompilerWarning)
    return pyopencl


@contextmanager
def _environment(name: str, value: str) -> Iterator[None]:
    """The environment variable has this value inside the block, unless it has one already."""
    if name in os.environ:
        yield
        return
    os.environ[name] = value
    try:
        yield
    finally:
        del os.environ[name]


@contextmanager
def _ctrl_c_kept_from_threads() -> Iterator[None]:
    """Threads and programs started inside the block never see Ctrl-C; this thread does, after the block.

    PoCL's threads start the linker, and a linker that Ctrl-C ends takes the whole process with it.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def check_process() -> None:
    """Refuse to call the driver in a child that was forked after it was loaded: such a call never returns.

    Raises:
        DeviceError: this is such a child.
    """
    if _forked:
        raise DeviceError(
            "device: expected a process that opens its own, got one forked from a process with a device open, where "
            'every call would hang; start it with multiprocessing.get_context("spawn")'
        )


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
    """("platform:device" index, platform name, device name, handle) of every device, in the loader's order.

    A platform of PoCL has its version in its name: several may be installed, such as pip's and the system's.
    """
    global _loaded
    check_process()
    cl = opencl()
    if not _loaded:
        caches.settle()
    _loaded = True
    try:
        platforms = cl.get_platforms()
    except cl.Error:
        return []
    found = []
    for p, platform in enumerate(platforms):
        try:
            with _ctrl_c_kept_from_threads():
                devices = platform.get_devices()
        except cl.Error:
            continue
        for d, device in enumerate(devices):
            found.append((f"{p}:{d}", _platform_name(platform), device.name.strip(), device))
    return found


def _platform_name(platform: Any) -> str:
    version = re.search(r"PoCL (\S+)", platform.version)
    return f"{platform.name.strip()} {version[1]}" if version else platform.name.strip()


def is_named(wanted: str, index: str, platform: str, device: str) -> bool:
    """Is the device the one at index `wanted` ("0:1"), or do its platform and name hold every word of it?"""
    if re.fullmatch(r"\d+:\d+", wanted):
        return wanted == index
    platform = platform.replace("Portable Computing Language", "PoCL, Portable Computing Language")
    return all(word in f"{platform} {device}".lower() for word in wanted.lower().split())


def is_pocl(handle: Any) -> bool:
    """Does the device belong to PoCL, whose kernels lie in a folder that this process marks while it loads them?"""
    return "PoCL" in handle.platform.version


def is_intel(handle: Any) -> bool:
    """Is the device one of Intel's runtimes'?"""
    return "Intel" in handle.platform.name


def needs_prelude(handle: Any) -> bool:
    """Are the driver's own built-ins to be replaced by `common/prelude.cl`? `LODBENCH_PRELUDE` = 0 or 1 decides.

    OpenCL leaves open how `mad`, `mix`, `dot` or `rsqrt` round, and Intel's differ from PoCL's: with the prelude a
    result has the same bytes on both. Some PoCL builds do not inline their own library on some hosts besides: every
    built-in is a call, or does not compile at all. Where PoCL does inline, the prelude compiles to the same code.
    """
    forced = os.environ.get("LODBENCH_PRELUDE")
    if forced in ("0", "1"):
        return forced == "1"
    known = is_pocl(handle) or is_intel(handle)
    return known and bool(handle.type & opencl().device_type.CPU)


def kind_of(handle: Any, forced: str | None = None) -> str:
    """The kind that kernels see, "cpu", "gpu" or "other": as `forced` or `LODBENCH_KIND` says, else what it is.

    Raises:
        ValueError: another kind.
    """
    forced = forced or os.environ.get("LODBENCH_KIND")
    if forced:
        if forced not in ("cpu", "gpu"):
            raise ValueError(f"kind, LODBENCH_KIND: expected cpu or gpu, got {forced!r}")
        return forced
    types = opencl().device_type
    return "cpu" if handle.type & types.CPU else "gpu" if handle.type & types.GPU else "other"


def one_core_of(handle: Any) -> Any:
    """A single compute unit of a device.

    Raises:
        Unsupported: it cannot be split.
    """
    cl = opencl()
    try:
        return handle.create_sub_devices([cl.device_partition_property.EQUALLY, 1])[0]
    except cl.Error as error:
        if handle.max_compute_units == 1:
            return handle
        raise Unsupported(f"needs a device that can be split, device has none: {error}") from None


def choose_device(wanted: str) -> Any:
    """The handle of the first device that `wanted` names; for "" PoCL's, else the first there is.

    Raises:
        DeviceError: no driver, no such device, or no linker where the driver would end the process for want of it.
    """
    found = list_devices()
    if not found:
        reason = caches.why_no_pocl() or "run `lodbench doctor`"
        raise DeviceError(f"device: expected an OpenCL driver, got none; {reason}")
    matches = [device for device in found if is_named(wanted or "pocl", *device[:3])]
    if wanted and not matches:
        labels = "; ".join(f"{index} {platform}: {name}" for index, platform, name, _ in found)
        raise DeviceError(f"device: expected one of [{labels}], got {wanted!r}")
    handle = (matches or found)[0][3]
    if is_pocl(handle) and (reason := caches.why_no_pocl()):
        raise DeviceError(f"device: {reason}")
    if "PoCL 3.0" in handle.platform.version and shutil.which("ld") is None:
        raise DeviceError(
            "device: expected the linker `ld` on PATH (PoCL calls it for every kernel and aborts without it), "
            "got none; install binutils"
        )
    return handle
