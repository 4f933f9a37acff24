"""Geometry images in files: .npz with the keys `positions` and `normals`, and `origin` where it is not zero."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import Any

import numpy as np

from lodbench.datasets_gen.arrays import BROKEN
from lodbench.datasets_gen.read import FileError, replacing
from lodbench.datasets_gen.surfaces import GeometryImage

KEYS = ("positions", "normals")


def read_geometry_image(path: str | os.PathLike[str], data: bytes | None = None) -> GeometryImage:
    """The image in an .npz file: positions and normals, (2^n + 1, 2^n + 1, 3) each.

    With `data` these are the bytes of the file, and `path` is its name in errors.

    Raises:
        FileError: no such file, truncated, a key missing, a wrong shape, NaN.
    """
    path = Path(path)
    try:
        with np.load(path if data is None else io.BytesIO(data), allow_pickle=False) as archive:
            missing = [key for key in KEYS if key not in archive]
            if missing:
                raise ValueError(f"expected the keys {', '.join(KEYS)}, got {sorted(archive)}")
            origin = archive["origin"] if "origin" in archive else None
            return GeometryImage(archive["positions"], archive["normals"], origin)
    except FileNotFoundError:
        raise FileError(f"{path}: no such file") from None
    except BROKEN as error:
        raise FileError(f"{path}: {' '.join(str(error).split())}") from error


def write_geometry_image(path: str | os.PathLike[str], image: GeometryImage) -> None:
    """Write the image as compressed .npz; the file is there whole or not at all.

    Raises:
        FileError: another suffix, or a place that cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() != ".npz":
        raise FileError(f"{path}: expected the suffix .npz, got {path.suffix!r}")
    with replacing(path) as stream:
        stream.write(geometry_image_bytes(image))


def geometry_image_bytes(image: GeometryImage) -> bytes:
    """The .npz file of an image."""
    packed = io.BytesIO()
    origin: dict[str, Any] = {} if image.origin is None else {"origin": image.origin}
    np.savez_compressed(packed, positions=image.positions, normals=image.normals, **origin)
    return packed.getvalue()
