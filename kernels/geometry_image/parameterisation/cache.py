"""Arrays kept on disk by what they were made of; a torn or foreign file counts as none."""

from __future__ import annotations

import hashlib
import io
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.arrays import BROKEN
from lodbench.datasets_gen.files import cache_folder, write_file
from lodbench.kernels.opencl import caches


def cache_path(parameters: str, *content: NDArray[Any]) -> Path:
    """The file for these parameters and this content, whether it exists or not."""
    key = hashlib.sha256(parameters.encode())
    for array in content:
        key.update(f"|{array.dtype}{array.shape}|".encode())
        key.update(np.ascontiguousarray(array).tobytes())
    return cache_folder() / "parameterisation" / f"{key.hexdigest()[:32]}.npz"


def read_arrays(path: Path) -> dict[str, NDArray[Any]]:
    """The file's arrays by name; empty where it cannot be read."""
    try:
        with np.load(path) as held:
            return {name: held[name] for name in held.files}
    except BROKEN:
        return {}


def write_arrays(path: Path, **arrays: Any) -> None:
    """Write all of them or nothing; a cache that cannot be written is no error."""
    packed = io.BytesIO()
    np.savez(packed, **arrays)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_file(path, packed.getvalue())
    except OSError:
        _complain(cache_folder())


@cache
def _complain(folder: Path) -> None:
    """Once per folder and process."""
    caches.note(
        f"cache folder {folder}: cannot be written, so all is made anew each time; make room there, or set "
        "LODBENCH_CACHE to another folder"
    )
