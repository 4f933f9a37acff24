"""What a record must say of a device, and where small facts are kept."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from lodbench.datasets_gen.files import write_file
from lodbench.kernels import caches


def cache_folder() -> Path:
    """Where small facts about devices and set-ups are kept; `LODBENCH_CACHE` moves it."""
    default = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "lodbench"
    return Path(os.environ.get("LODBENCH_CACHE") or default)


def write_cache(path: Path, content: str | bytes) -> None:
    """Write `content` so that a reader sees all of it or nothing; where it cannot be written, a line says so."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_file(path, content)
    except OSError:
        _complain(cache_folder())


@cache
def _complain(folder: Path) -> None:
    """Once per folder and process."""
    caches.note(
        f"cache folder {folder}: cannot be written, so all is made anew each time; make room there, or set "
        "LODBENCH_CACHE to another folder"
    )


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
    prelude: bool
