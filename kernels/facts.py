"""What a record must say of a device, and the one defect that has to be measured: slow built-ins."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lodbench.datasets_gen.files import write_file
from lodbench.kernels import caches

if TYPE_CHECKING:
    from lodbench.kernels.device import Device

PROBE = Path(__file__).parent / "common/probe.cl"


def cache_folder() -> Path:
    """Where small facts about devices and set-ups are kept; `LODBENCH_CACHE` moves it."""
    default = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "lodbench"
    return Path(os.environ.get("LODBENCH_CACHE") or default)


def write_cache(path: Path, content: str | bytes) -> None:
    """Write `content` so that a reader sees all of it or nothing; a cache that cannot be written is no error."""
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_file(path, content)


@dataclass(frozen=True)
class DeviceFacts:
    """What a record must say of the device it ran on."""

    name: str
    platform: str
    driver: str
    version: str
    kind: str
    compute_units: int
    memory_bytes: int
    largest_allocation_bytes: int
    local_bytes: int
    extensions: tuple[str, ...]
    one_core: bool
    builtins_ratio: float
    prelude: bool


def builtins_ratio(device: Device) -> float:
    """How many times slower the driver's `mad` is than `a * b + c`; kept on disk per driver.

    Some PoCL builds do not inline their own library on some hosts; every built-in is then a call, and the prelude
    shadows them. `LODBENCH_PRELUDE` = 0 or 1 decides without measuring.
    """
    forced = os.environ.get("LODBENCH_PRELUDE")
    if forced in ("0", "1"):
        return float("inf") if forced == "1" else 1.0
    cl, handle = device.cl, device.handle
    key = f"{handle.platform.version}|{handle.version}|{handle.name}|{handle.driver_version}"
    path = cache_folder() / "builtins" / (hashlib.sha256(key.encode()).hexdigest()[:16] + ".json")
    try:
        return float(json.loads(path.read_text("utf-8"))["ratio"])
    except (OSError, ValueError, KeyError, TypeError):
        pass
    program = device.compile([(PROBE.name, PROBE.read_text("utf-8"))], "")
    count, local = 1 << 16, 64
    memory = cl.Buffer(device.context, cl.mem_flags.READ_WRITE, 4 * count)
    best: dict[str, float] = {}
    for name in (
        "probe_builtin",
        "probe_operator",
    ) * 8:  # the first turn compiles, the minimum drops it
        kernel = cl.Kernel(program, name)
        kernel.set_args(memory, np.uint32(count))
        with caches.loading():
            event = cl.enqueue_nd_range_kernel(device.queue, kernel, (count,), (local,))
            event.wait()
        seconds = (event.profile.end - event.profile.start) * 1e-9
        best[name] = min(best.get(name, np.inf), seconds)
    ratio = round(best["probe_builtin"] / max(best["probe_operator"], 1e-9), 2)
    write_cache(path, json.dumps({"ratio": ratio, "device": key}))
    if not path.exists():
        caches.note(
            f"cache folder {cache_folder()}: cannot be written, so the driver is measured at each start; make room "
            "there, or set LODBENCH_CACHE to another folder"
        )
    return ratio
