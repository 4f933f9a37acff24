"""The rows of a `samples.jsonl`: appended as they happen, packed when all is done, written by one process at a time."""

from __future__ import annotations

import dataclasses
import gzip
import json
import math
import zlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from lodbench.datasets_gen.files import write_file
from lodbench.harness.record.foreign import check_row, parse_json, refuse_links
from lodbench.harness.record.lock import Lock

SAMPLES = "samples.jsonl"
PACKED = "samples.jsonl.gz"
LARGEST = 1 << 30  # bytes of rows: a small file may unpack to any size


def plain(value: Any) -> Any:
    """`value` as JSON can hold it: dataclasses as objects, NaN and infinity as null."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, str | int | bool):
        return value
    if isinstance(value, Iterable):
        return [plain(item) for item in value]
    return str(value)


def _is_json(line: bytes) -> bool:
    try:
        json.loads(line)
    except (ValueError, RecursionError):
        return False
    return True


def _whole(content: bytes) -> bytes:
    """The rows that were written whole, each with its newline; a row cut short is no JSON."""
    end = content.rfind(b"\n") + 1
    last = content[end:]
    return content if not last else content[:end] + (last + b"\n" if _is_json(last) else b"")


def rows_file(folder: Path) -> Path:
    """The file of a run's rows, packed or not; it need not be there."""
    plain_file = folder / SAMPLES
    return folder / PACKED if not plain_file.exists() and (folder / PACKED).exists() else plain_file


def _content(path: Path) -> bytes:
    if path.suffix != ".gz":
        return path.read_bytes()
    try:
        with gzip.open(path) as file:
            content = file.read(LARGEST + 1)
    except (EOFError, gzip.BadGzipFile, zlib.error) as error:
        raise ValueError(f"{path}: expected rows packed by gzip, got {error}") from None
    if len(content) > LARGEST:
        raise ValueError(f"{path}: expected at most {LARGEST:,} bytes of rows, got more")
    return content


def pack(folder: Path) -> None:
    """Compress the rows of a run that is done, ten to one; a writer unpacks them again. Same rows, same bytes."""
    path = folder / SAMPLES
    write_file(folder / PACKED, gzip.compress(path.read_bytes(), mtime=0))
    path.unlink()


def read_rows(path: Path) -> list[dict[str, Any]]:
    """All rows of a `samples.jsonl`, packed or not; a torn last line is dropped.

    Raises:
        ValueError: a line before the last is not JSON, or a row is none that a record holds; or it does not unpack.
    """
    rows = []
    for number, line in enumerate(_whole(_content(path)).split(b"\n"), 1):
        if not line.strip():
            continue
        row = parse_json(line, f"{path}: line {number}")
        check_row(row, f"{path}: line {number}")
        rows.append(row)
    return rows


class Writer:
    """Appends rows to a run's `samples.jsonl`, each flushed at once; the file is this process's as long as it lives.

    Raises:
        Busy: another process writes to the folder.
    """

    def __init__(self, folder: Path) -> None:
        path = folder / SAMPLES
        refuse_links(folder)
        if (packed := rows_file(folder)) != path:
            write_file(path, _content(packed))
            packed.unlink()
        self._file = path.open("ab", buffering=0)
        try:
            self._lock = Lock(self._file, folder)
        except BaseException:
            self._file.close()
            raise
        content = path.read_bytes()
        whole = _whole(content)
        if len(whole) > len(content):
            self._append(whole[len(content) :])
        else:  # a torn last line: the next row must not be glued to it
            self._file.truncate(len(whole))

    def _append(self, line: bytes) -> None:
        data = memoryview(line)
        while data:
            data = data[self._file.write(data) :]

    def write(self, kind: str, **row: Any) -> None:
        """Append one row.

        Raises:
            OSError: the disk is full, or gone; what was written before stays.
        """
        line = json.dumps({"kind": kind, **plain(row)}, allow_nan=False) + "\n"
        self._append(line.encode())

    def close(self) -> None:
        self._lock.release()
        self._file.close()


def check_free(folder: Path) -> None:
    """Refuse a folder that another process measures into.

    Raises:
        Busy: there is one.
    """
    path = folder / SAMPLES
    if path.exists():
        with path.open("ab") as file:
            Lock(file, folder).release()
