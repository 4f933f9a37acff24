"""Where and with what a run was made: CPU, device, driver, packages, commit, variables."""

from __future__ import annotations

import datetime
import importlib.metadata
import os
import platform
import re
import subprocess
from pathlib import Path
from typing import Any

import psutil

from lodbench.harness.record.record import plain
from lodbench.kernels.opencl import Device

VARIABLES = ("POCL_", "PYOPENCL_", "LODBENCH_", "OCL_ICD_", "OMP_NUM_THREADS")
PACKAGES = (
    "lodbench", "pyopencl", "pocl-binary-distribution", "numpy", "scipy", "trimesh",
    "fast-simplification", "libigl", "vtk", "meshoptimizer", "manifold3d", "pyfqmr", "splipy",
    "matplotlib", "moderngl",
)  # fmt: skip


def _git(*arguments: str) -> str | None:
    try:
        done = subprocess.run(
            ["git", "-C", str(Path(__file__).parent), *arguments],
            capture_output=True,
            text=True,
            timeout=20,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()


def commit() -> tuple[str, bool]:
    """(short commit, whether the tree was changed since); ("unknown", False) outside a checkout."""
    top = _git("rev-parse", "--show-toplevel")
    # an installed copy may lie inside some other project's checkout
    if top is None or Path(top).resolve() != Path(__file__).resolve().parents[2]:
        return "unknown", False
    short = _git("rev-parse", "--short", "HEAD")
    if not short:
        return "unknown", False
    return short, bool(_git("status", "--porcelain", "--untracked-files=no"))


def load_average() -> float | None:
    """The one-minute load average, or None where the system has none."""
    return round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None


def cpu_name() -> str:
    """The processor's name as the system gives it."""
    try:
        for line in Path("/proc/cpuinfo").read_text("utf-8").splitlines():
            if line.lower().startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def package_versions() -> dict[str, str | None]:
    """Installed versions of what the numbers depend on; None where a package is absent."""
    versions: dict[str, str | None] = {}
    for name in PACKAGES:
        try:
            versions[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            versions[name] = None
    return versions


def variables() -> dict[str, str]:
    """Environment variables that change what OpenCL or lodbench do; of a path, its last part alone."""
    return {
        name: Path(value).name if os.path.isabs(value) else value
        for name, value in sorted(os.environ.items())
        if name.startswith(VARIABLES)
    }


def now() -> str:
    """This moment, UTC, to the second."""
    return datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")


def machine() -> dict[str, Any]:
    """CPU, memory, system and load at this moment."""
    governor = Path("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor")
    return {
        "cpu": cpu_name(),
        "cores": len(os.sched_getaffinity(0))
        if hasattr(os, "sched_getaffinity")
        else os.cpu_count(),
        "memory_bytes": psutil.virtual_memory().total,
        "system": platform.platform(),
        "python": platform.python_version(),
        "governor": governor.read_text("utf-8").strip() if governor.exists() else None,
        "load": load_average(),
    }


def environment(device: Device, options: dict[str, Any], seed: int) -> dict[str, Any]:
    """All of it, for `run.json`."""
    short, dirty = commit()
    facts = plain(device.facts)
    llvm = re.search(r"LLVM ([\w.]+)", facts["driver"])
    pocl = re.search(r"PoCL ([\w.]+)", facts["driver"], re.I)
    return {
        "started": now(),
        "commit": short,
        "dirty": dirty,
        "machine": machine(),
        "slug": device.slug,
        "device": facts,
        "pocl": pocl[1] if pocl else None,
        "llvm": llvm[1] if llvm else None,
        "packages": package_versions(),
        "variables": variables(),
        "options": options,
        "seed": seed,
    }
