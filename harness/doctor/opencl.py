"""The doctor's look at OpenCL itself: driver files, caches, the loader, the linker, a kernel that runs."""

from __future__ import annotations

import dataclasses
import importlib.util
import json
import os
import shlex
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal

from lodbench.datasets_gen.files import cache_folder

TIMEOUT_S = 120.0  # of one step: a first build takes seconds, a driver that hangs takes for ever
LOW_SPACE = 200 << 20  # bytes; a full sweep leaves some 100 MB of compiled kernels
MANAGERS = {
    "apt-get": "apt-get install -y binutils", "dnf": "dnf install -y binutils",
    "apk": "apk add binutils", "pacman": "pacman -S --noconfirm binutils",
    "zypper": "zypper install -y binutils",
}  # fmt: skip


@dataclasses.dataclass(frozen=True)
class Finding:
    """One thing that was looked at: `status` "ok", "warn" or "fail", and the shell line that mends it, if any."""

    what: str
    status: Literal["ok", "warn", "fail"]
    detail: str
    mend: str = ""


def pip(*packages: str) -> str:
    return f"{sys.executable} -m pip install " + " ".join(
        f'"{name}"' if "[" in name else name for name in packages
    )


def _child(
    step: str, environment: Mapping[str, str] | None = None
) -> tuple[dict[str, Any] | None, str]:
    """What a step of `probe` found; or None and why it did not get that far."""
    command = [sys.executable, "-m", "lodbench.harness.doctor.probe", step]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, errors="replace", timeout=TIMEOUT_S,
            env={**os.environ, **(environment or {})},
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return None, f"no answer within {TIMEOUT_S:.0f} s"
    except OSError as error:
        return None, str(error)
    if done.returncode == 0:
        try:
            return json.loads(done.stdout.splitlines()[-1]), ""
        except (IndexError, ValueError):
            pass
    said = [line.strip() for line in (done.stdout + done.stderr).splitlines() if line.strip()]
    ended = f"exit code {done.returncode}"
    if done.returncode < 0:
        ended = f"ended by {signal.Signals(-done.returncode).name}"
    telling = [line for line in said if "rror" in line] or said
    return None, f"{ended}: {' | '.join(telling[-2:])}"[:400]


def cache_folders() -> dict[str, Path]:
    """Where PoCL and lodbench keep compiled kernels and measured facts."""
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    pocl = Path(os.environ.get("POCL_CACHE_DIR") or base / "pocl" / "kcache")
    # after a crash a clean one inside is used: see kernels/opencl/caches.py, which needs numpy to be imported
    clean = max(
        pocl.glob("lodbench-clean-*"),
        key=lambda folder: (len(folder.name), folder.name),
        default=pocl,
    )
    return {
        "PoCL": clean,
        "lodbench": cache_folder(),
    }


def cut_short(folder: Path) -> list[Path]:
    """Compiled kernels whose file ends before its table of sections does; to run one is a bus error."""
    # os.walk goes on where another process has removed a folder meanwhile; Path.rglob raises
    files = [Path(base, name) for base, _, names in os.walk(folder) for name in names]
    return [file for file in sorted(files) if file.suffix == ".so" and not _whole(file)]


def _whole(file: Path) -> bool:
    try:
        data = file.read_bytes()
    except OSError:
        return True  # another process's build has renamed or removed it since the folder was listed
    if len(data) < 64:
        return False
    if data[:5] != b"\x7fELF\x02":
        return True  # another system's format
    (start,), (each, count) = (
        struct.unpack_from("<Q", data, 40),
        struct.unpack_from("<HH", data, 58),
    )
    return start + each * count <= len(data)


def _away(folder: Path) -> str:
    """The line that puts a damaged cache out of the way."""
    return f'mv {shlex.quote(str(folder))} "$(mktemp -d)"'


def writable(folder: Path) -> str:
    """Why nothing can be written there, or ""."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder) as file:
            file.write(bytes(1 << 16))
    except OSError as error:
        return error.strerror or str(error)
    return ""


def icd_files() -> tuple[list[Path], Path]:
    """The .icd files that the loader reads, and the folder (or file) it looks in."""
    place = Path(os.environ.get("OCL_ICD_VENDORS") or "/etc/OpenCL/vendors")
    files = sorted(place.glob("*.icd")) if place.is_dir() else [place] if place.is_file() else []
    spec = importlib.util.find_spec("pyopencl")
    if spec and spec.origin:  # the wheel brings PoCL beside its own loader
        files += sorted((Path(spec.origin).parent / ".libs").glob("*.icd"))
    return files, place


def icds() -> Iterator[Finding]:
    files, place = icd_files()
    if os.environ.get("OCL_ICD_VENDORS") and not place.exists():
        yield Finding(
            "driver files", "fail", f"OCL_ICD_VENDORS names {place}, which is not there: no driver is loaded",
            "unset OCL_ICD_VENDORS",
        )  # fmt: skip
        return
    broken = []
    for file in files:
        library = Path(file.read_text(errors="replace").strip())
        if library.is_absolute() and not library.exists():
            broken.append(f"{file} names {library}, which is not there")
    names = ", ".join(str(file) for file in files) or "none"
    if broken:
        mend = f"echo /path/to/the/driver.so > {files[0]}"
        yield Finding("driver files", "warn", "; ".join(broken), mend)
    else:
        yield Finding("driver files", "ok" if files else "warn", f"{names} (looked in {place})")


def caches() -> Iterator[Finding]:
    variables = {"PoCL": "POCL_CACHE_DIR", "lodbench": "LODBENCH_CACHE"}
    for name, folder in cache_folders().items():
        mend = f'export {variables[name]}="$(mktemp -d)"'
        if reason := writable(folder):
            # PoCL without its cache is no platform at all; lodbench does without
            status = "warn" if name == "lodbench" else "fail"
            yield Finding(f"{name} cache", status, f"{folder}: cannot be written: {reason}", mend)
            continue
        free = shutil.disk_usage(folder).free
        damaged = cut_short(folder) if name == "PoCL" else []
        if damaged:
            detail = f"kernels cut short: {len(damaged)}, such as {damaged[0]}"
            yield Finding(f"{name} cache", "fail", detail, _away(folder))
        elif free < LOW_SPACE:
            detail = f"{folder}: only {free >> 20} MB left"
            yield Finding(f"{name} cache", "warn", detail, mend)
        else:
            yield Finding(f"{name} cache", "ok", str(folder))


def _linker_line() -> str:
    places = "/usr/bin:/bin:/usr/sbin:/sbin"  # PATH itself may be what is wrong
    if found := shutil.which("ld", path=places):
        return f'export PATH="$PATH:{Path(found).parent}"'
    return next(
        (line for name, line in MANAGERS.items() if shutil.which(name, path=places)),
        MANAGERS["apt-get"],
    )


def opencl() -> Iterator[Finding]:
    found, reason = _child("devices")
    if found is None:
        mend = pip("--force-reinstall", "pyopencl[pocl]")
        yield Finding("OpenCL loader", "fail", f"pyopencl cannot be used: {reason}", mend)
        return
    yield Finding("OpenCL loader", "ok", f"pyopencl {found['pyopencl']}")
    listed = "; ".join(f"{index} {platform}: {name}" for index, platform, name in found["devices"])
    if listed:
        yield Finding("devices", "ok", listed)
    else:
        yield Finding(
            "devices", "fail", "no platform, or none with a device", _line_for_no_device()
        )
    linker = shutil.which("ld")
    if linker:
        yield Finding("linker", "ok", linker)
    elif not listed or "Portable Computing" in listed:
        detail = "no `ld` on PATH: PoCL calls it for every kernel, and ends the process without it"
        yield Finding("linker", "fail", detail, _linker_line())
    if listed:
        found = list(kernel())
        yield from found
        if all(finding.status != "fail" for finding in found):
            yield from own_kernels()


def _line_for_no_device() -> str:
    """What hides every device, most likely first: a variable, PoCL's cache, or PoCL is not there."""
    for name in ("OCL_ICD_VENDORS", "POCL_DEVICES"):
        if name in os.environ:
            return f"unset {name}"
    if writable(cache_folders()["PoCL"]):
        return 'export POCL_CACHE_DIR="$(mktemp -d)"'
    return pip("pyopencl[pocl]")


def _with_fresh_caches(step: str) -> dict[str, Any] | None:
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as fresh:
        names = ("POCL_CACHE_DIR", "XDG_CACHE_HOME", "LODBENCH_CACHE")
        return _child(step, {name: str(Path(fresh) / name) for name in names})[0]


def own_kernels() -> Iterator[Finding]:
    """The project's kernels, run as they lie in the cache: a damaged one ends its process."""
    folder = cache_folders()["PoCL"]
    found, reason = _child("own")
    if found is not None:
        detail = f"simplify, refine and render run out of {folder}, {found['seconds']:.2f} s"
        yield Finding("own kernels", "ok", detail)
    elif _with_fresh_caches("own") is not None:
        detail = f"run with fresh caches, not out of {folder}, where some are damaged: {reason}"
        yield Finding("own kernels", "fail", detail, _away(folder))
    else:
        mend = "POCL_DEBUG=error,warning lodbench doctor"
        yield Finding("own kernels", "fail", reason, mend)


def kernel() -> Iterator[Finding]:
    found, reason = _child("kernel")
    if found is None:
        folders = cache_folders()
        if _with_fresh_caches("kernel") is not None:
            old = ", ".join(map(str, folders.values()))
            detail = f"works with fresh caches, not with the old ones ({old}): {reason}"
            mend = 'export POCL_CACHE_DIR="$(mktemp -d)" LODBENCH_CACHE="$(mktemp -d)"'
        else:
            detail = reason
            mend = "POCL_DEBUG=error,warning OCL_ICD_DEBUG=7 lodbench doctor"
            if "ld" in reason.split() or "linker" in reason:
                mend = _linker_line()
            elif os.environ.get("LODBENCH_DEVICE") and "expected one of" in reason:
                mend = "unset LODBENCH_DEVICE"
        yield Finding("a kernel", "fail", detail, mend)
        return
    right = "gives the right numbers" if found["right"] else "gives WRONG numbers"
    detail = f"{right} on {found['device']} ({found['driver']}), first run {found['seconds']:.2f} s"
    yield Finding("a kernel", "ok" if found["right"] else "fail", detail)
    if name := found.get("compiles_for"):
        detail = f"PoCL's compiler knows no name for this processor, and compiles for {name}"
        yield Finding("processor", "ok", detail)
    if os.environ.get("LODBENCH_PRELUDE") == "0":
        detail = "LODBENCH_PRELUDE=0 keeps the prelude off: some PoCL builds are many times slower, or abort"
        yield Finding("built-ins", "warn", detail, "unset LODBENCH_PRELUDE")
