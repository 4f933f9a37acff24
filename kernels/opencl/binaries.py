"""Built programs on disk, for drivers that keep none: Intel's takes a second or two for each, in every process anew.

A file is a checksum and the driver's binary; what was cut short or damaged is built again, and what cannot be written
is not kept. Its name comes of all that the binary depends on, the processor's abilities too, since a home may have many
hosts.
"""

from __future__ import annotations

import hashlib
import warnings
from functools import cache
from pathlib import Path
from typing import Any

from lodbench.datasets_gen.files import cache_folder, write_file

KEEPS_NONE = "Intel"  # what platforms' names begin with whose driver keeps nothing
DIGEST = 32  # bytes of a checksum


@cache
def _abilities() -> tuple[str, ...]:
    """What the processor says of itself: the same for every program of this process."""
    try:
        cpu = Path("/proc/cpuinfo").read_text("utf-8").split("\n\n", 1)[0]
    except OSError:
        cpu = ""
    return tuple(line for line in cpu.splitlines() if line.startswith(("flags", "Features")))


def path_of(*words: str) -> Path:
    """The file of what is built from these: driver, device, options, text."""
    name = hashlib.sha256("\0".join((*words, *_abilities())).encode()).hexdigest()
    return cache_folder() / "programs" / name


def load(path: Path) -> bytes | None:
    """The binary that was kept there; None where there is none, or not the whole of it."""
    try:
        data = path.read_bytes()
    except OSError:
        return None
    binary = data[DIGEST:]
    return binary if binary and hashlib.sha256(binary).digest() == data[:DIGEST] else None


def keep(path: Path, binary: bytes) -> None:
    """Write the binary there, if that can be done."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_file(path, hashlib.sha256(binary).digest() + binary)
    except OSError:
        return


def built(cl: Any, context: Any, device: Any, text: str, options: list[str]) -> Any:
    """The built program of `text`, from disk where the driver keeps none.

    Raises:
        cl.Error: the build failed.
    """
    platform = device.platform
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", cl.CompilerWarning)  # remarks on what was built
        if not platform.name.startswith(KEEPS_NONE):
            return cl.Program(context, text).build(options=options)
        words = platform.name, platform.version, device.driver_version, device.name, *options, text
        path = path_of(*words)
        binary = load(path)
        if binary is not None:
            try:
                return cl.Program(context, [device], [binary]).build(options=options)
            except cl.Error:  # of another driver under the same name
                path.unlink(missing_ok=True)
        program = cl.Program(context, text).build(options=options)
    keep(path, program.binaries[0])
    return program
