"""Which processor PoCL compiles for, where its LLVM is older than the processor and knows no name for it.

The LLVM 14 in PoCL's wheel calls such a processor "generic" (AMD family 26, Zen 5, is one), and its own front end then
refuses that name: no kernel builds at all. PoCL has no setting for the name, so it is written over where PoCL keeps it,
in this process's memory, before the first build: pocl/pocl issue 1049 describes the failure.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any, BinaryIO

UNKNOWN = b"generic\0"
SEARCHED = (
    4096  # bytes of PoCL's record of a device; the name stands behind the target's, 640 bytes in
)
# names that LLVM 14 knows and that take no more room than "generic", with the flags that code for them may use;
# "skx" has twice the registers of the others, and the wheel's built-ins are compiled for it where there is AVX-512
NAMES = (
    ("skx", "", {f"avx512{part}" for part in ("f", "bw", "cd", "dq", "vl")} | {"fma", "bmi2"}),
    ("znver3", "AuthenticAMD", {"avx2", "fma", "bmi2", "f16c", "abm", "movbe", "sse4a"}),
    ("haswell", "", {"avx2", "fma", "bmi2", "f16c", "abm", "movbe"}),
    ("x86-64", "", set()),
)


REFUSED = "unknown target CPU"  # of a build, where no name could be written


def explained(text: str) -> str:
    """A failed build's text, and what it means where the processor has no name."""
    if REFUSED not in text:
        return text
    return (
        f"{text}\nPoCL's compiler is older than this processor and knows no name for it: "
        "a newer PoCL, or another OpenCL driver, is needed"
    )


def name_for(cpuinfo: str) -> str:
    """The name that LLVM has for the newest processor whose code this one can run, from `/proc/cpuinfo`'s text."""
    flags = next((line for line in cpuinfo.splitlines() if line.startswith("flags")), "").split()
    return next(
        name for name, vendor, needed in NAMES if vendor in cpuinfo and needed <= set(flags)
    )


def _words(memory: BinaryIO, address: int) -> Iterator[int]:
    """The 8-byte words from `address` on, as far as there is memory."""
    memory.seek(address)
    data = memory.read(SEARCHED)
    for (word,) in struct.iter_unpack("<Q", data[: len(data) & ~7]):
        yield word


def _text(memory: BinaryIO, address: int, size: int) -> bytes:
    """What stands there; nothing where that is no address."""
    try:
        memory.seek(address)
        return memory.read(size)
    except (OSError, ValueError, OverflowError):
        return b""


def name_unknown(handle: Any) -> str:
    """Have PoCL compile for a processor that its LLVM knows; which, or "" where it needs no help or none is possible.

    `handle` is one of PoCL's devices. Does nothing twice.
    """
    if not handle.version.endswith("x86_64-unknown-linux-gnu-generic"):
        return ""
    try:
        name = name_for(Path("/proc/cpuinfo").read_text("utf-8"))
        with open("/proc/self/mem", "r+b", buffering=0) as memory:
            words = list(_words(memory, handle.int_ptr))
            for target, place in pairwise(words):
                if _text(memory, target, 7) != b"x86_64-":
                    continue
                found = _text(memory, place, len(UNKNOWN))
                if found == UNKNOWN:
                    memory.seek(place)
                    memory.write(name.encode() + b"\0")
                elif not found.startswith(name.encode() + b"\0"):
                    continue
                return name
    except (OSError, ValueError):
        pass
    return ""
