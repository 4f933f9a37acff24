"""PoCL's folder of compiled kernels: which one is used, whether it can be written, and whether a crash left it damaged.

PoCL maps what it finds there without looking: a kernel cut short by a full disk or a power cut ends the process by
SIGBUS, with no word. So a process holds a mark in the folder while it loads kernels. A mark whose owner is gone makes
the next start say so and use a clean folder inside the old one, which later starts take too. A mark is a locked file:
the lock dies with its owner, whatever that died of.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import shutil
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

try:
    import fcntl
except ImportError:  # no such locks on this system: damage stays for `lodbench doctor` to find
    fcntl = None

MARK = "lodbench-loading-"
CLEAN = "lodbench-clean-"
SLOW_S = 0.3  # a build takes less where the driver has its kernels already
ROOM = 1 << 20  # bytes that are tried; the kernels of one system take half of it
LOW_SPACE = 8 << 20  # bytes left on the disk, less than which the driver might not come through


def note(line: str) -> None:
    """One line on standard error, for what nobody asked for and everybody should know."""
    if sys.stderr is not None:
        sys.stderr.write(f"lodbench: {line}\n")
        sys.stderr.flush()


def pocl_folder() -> Path:
    """Where PoCL keeps compiled kernels: `POCL_CACHE_DIR`, or its own default."""
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return Path(os.environ.get("POCL_CACHE_DIR") or base / "pocl" / "kcache")


def unwritable(folder: Path, size: int = ROOM) -> str:
    """Why `size` bytes cannot be written there and leave some room, or ""; the folder is made if need be."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(bytes(size))
    except OSError as error:
        return error.strerror or str(error)
    free = shutil.disk_usage(folder).free
    return f"only {free >> 20} MB left" if free < LOW_SPACE else ""


def why_no_pocl() -> str:
    """The folder that keeps PoCL from working and what to do, or ""."""
    folder = pocl_folder()
    reason = unwritable(folder)
    return reason and (
        f"PoCL's cache folder {folder}: cannot be written: {reason}; make room there, or set POCL_CACHE_DIR "
        "to another folder"
    )


def _abandoned(mark: Path) -> bool:
    """Is the owner of this mark gone? The mark is then taken away."""
    try:
        with open(mark, "rb") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)  # pyright: ignore[reportOptionalMemberAccess]
            if not os.fstat(file.fileno()).st_nlink:
                return False  # its owner was done between our look and our lock
            mark.unlink()
            return True
    except OSError:  # locked: its owner lives; or gone by now
        return False


def settle() -> None:
    """Choose PoCL's folder for this process, before the driver is loaded: the newest clean one, if there is any."""
    base = pocl_folder()
    if fcntl is None or not base.is_dir():
        return
    try:
        cleaned = [int(p.name.removeprefix(CLEAN)) for p in base.glob(f"{CLEAN}*")]
        newest = max(cleaned, default=0)
        used = base / f"{CLEAN}{newest}" if newest else base
        if any([_abandoned(mark) for mark in used.glob(f"{MARK}*")]):
            clean = base / f"{CLEAN}{newest + 1}"
            clean.mkdir(exist_ok=True)
            note(
                f"a process died while it loaded kernels from {used}, which may be damaged: "
                f"they are built afresh in {clean}"
            )
            used = clean
    except (OSError, ValueError):
        return  # the driver itself will say what it cannot read
    if used != base:
        os.environ["POCL_CACHE_DIR"] = str(used)


class _Mark:
    """This process's mark: held from the first of some loads to the next time that the device was waited for."""

    def __init__(self) -> None:
        self._file: Any = None  # open as long as the mark lies there: it holds the lock
        self._left: Any = None
        self._lock = threading.Lock()

    def begin(self) -> None:
        """Put the mark down, if it does not lie there; where that fails there is none."""
        with self._lock:
            if self._file is not None or fcntl is None:
                return
            path = pocl_folder() / f"{MARK}{os.getpid()}"
            hidden = path.with_name(f".{path.name}")  # nobody may see it before it is locked
            try:
                self._file = open(hidden, "wb")
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                hidden.rename(path)
                self._path = path
            except OSError:
                self._drop(hidden)

    def end(self) -> None:
        """Take the mark away."""
        if self._file is not None:
            with self._lock:
                self._drop(self._path)

    def _drop(self, path: Path) -> None:
        if self._file is not None:
            with contextlib.suppress(OSError):
                path.unlink()
            self._file.close()
            self._file = None

    def leave(self) -> None:
        """Keep the mark beyond the end of this process: what was loaded is damaged."""
        self.begin()
        with self._lock:
            self._left, self._file = self._file, None


mark = _Mark()
_announced = False
atexit.register(mark.end)


def damaged() -> str:
    """What to say of a kernel that is not what was built; the next start takes a clean folder."""
    mark.leave()
    return f"PoCL's cache folder {pocl_folder()} is damaged: the next start builds afresh"


@contextlib.contextmanager
def loading() -> Iterator[None]:
    """The block builds or loads kernels and waits for them; one that takes its time is announced on a terminal."""
    global _announced
    timer = threading.Timer(SLOW_S, note, ["compiling kernels for this device, once ..."])
    timer.daemon = True
    if sys.stderr is not None and sys.stderr.isatty() and not _announced:
        timer.start()
    mark.begin()
    start = time.perf_counter()
    try:
        yield
    finally:
        mark.end()
        timer.cancel()
        _announced = _announced or time.perf_counter() - start > SLOW_S
