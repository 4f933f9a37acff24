"""Files that appear whole under their name, or leave what was there: the one way in which files are written.

And the one folder in which something is kept from run to run.
"""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

PART = ".part"


def cache_folder() -> Path:
    """Where lodbench keeps what it would else make or download again; `LODBENCH_CACHE` moves it."""
    import platformdirs

    return Path(os.environ.get("LODBENCH_CACHE") or platformdirs.user_cache_dir("lodbench"))


def beside(target: Path) -> Path:
    """Where the new content of `target` is written until it takes its name."""
    mine = f"{os.getpid()}.{threading.get_ident()}"  # two threads may write one file
    return target.with_name(f".{target.name[:100]}.{mine}{PART}")


def is_part(path: Path) -> bool:
    """Is this what a process that was killed left of a file that it was writing?"""
    return path.name.endswith(PART)


@contextlib.contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """A binary stream to a file beside `path`, which takes its name when all went well.

    On any failure the new file is removed and the old one is untouched.

    Raises:
        OSError: it cannot be written, or the disk is full; the error names `path`.
    """
    target = Path(path).resolve()  # through a symbolic link, which stays one
    fresh = beside(target)
    try:
        fresh.unlink(missing_ok=True)  # of a process that had this number before
        with fresh.open("xb") as stream:
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        if target.exists():
            fresh.chmod(target.stat().st_mode & 0o777)
        fresh.replace(target)
    except OSError as error:
        error.filename, error.filename2 = str(path), None
        raise
    finally:
        with contextlib.suppress(OSError):
            fresh.unlink(missing_ok=True)


def write_file(path: str | os.PathLike[str], content: bytes | str) -> None:
    """Write `content`, text as UTF-8, in place of whatever was at `path`.

    Raises:
        OSError: as `replacing`.
    """
    with replacing(path) as stream:
        stream.write(content.encode() if isinstance(content, str) else content)
