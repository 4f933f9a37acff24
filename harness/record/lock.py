"""One writer per run folder: a lock that ends with its process, however that ends."""

from __future__ import annotations

import os
from pathlib import Path
from typing import BinaryIO

import psutil

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None

OWNER = ".owner.part"  # where the system locks no files: the writer's number and start


class Busy(ValueError):
    """Another process measures into this folder."""


class Lock:
    """The folder to oneself until `release`, or until the process is gone.

    Args:
        file: the open file that is locked, where the system locks files.
        folder: its folder, which errors name.

    Raises:
        Busy: another has it.
        OSError: the folder cannot be written to.
    """

    def __init__(self, file: BinaryIO, folder: Path) -> None:
        self._file, self._note = file, folder / OWNER
        if fcntl is not None:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                return
            except BlockingIOError:
                raise _busy(folder, _holder(file)) from None
        if (process := _alive(self._note)) is not None:
            raise _busy(folder, process)
        self._note.write_text(f"{os.getpid()} {psutil.Process().create_time()}")

    def release(self) -> None:
        """Let others have it."""
        if fcntl is None:
            self._note.unlink(missing_ok=True)
        else:
            fcntl.flock(self._file, fcntl.LOCK_UN)


def _busy(folder: Path, process: int | None) -> Busy:
    by = f", which process {process} writes to" if process else ""
    return Busy(f"out: expected a folder that no other run is writing to, got {folder}{by}")


def _holder(file: BinaryIO) -> int | None:
    """The process that has locked this file, where the system tells."""
    try:
        lines = Path("/proc/locks").read_text("utf-8").splitlines()
    except OSError:
        return None
    inode = f":{os.fstat(file.fileno()).st_ino}"
    words = (line.split() for line in lines)
    return next((int(w[4]) for w in words if w[1] == "FLOCK" and w[5].endswith(inode)), None)


def _alive(note: Path) -> int | None:
    """The process of this note, if it is the one that wrote it: numbers are given again."""
    try:
        number, started = note.read_text("utf-8").split()
        same = psutil.Process(int(number)).create_time() == float(started)
    except (OSError, ValueError, psutil.Error):
        return None
    return int(number) if same else None
