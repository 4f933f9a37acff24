"""Height maps: grids of values 0 to 1, of a picture or an array."""

from __future__ import annotations

import io
import os
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.read import FileError, file_bytes
from lodbench.datasets_gen.surfaces import Floats

SUFFIXES = (".png", ".npy")
WHOLE = {np.dtype(np.uint8): 255, np.dtype(np.uint16): 65535}  # 1 as so many


def height_map(given: str | os.PathLike[str] | NDArray[Any]) -> Floats:
    """Values (h, w) float32, 0 to 1, the first row at the top (v = 1).

    Args:
        given: a PNG of 8 or 16 bits (of colours their luma is taken, without gamma) or an .npy file; or an array
            (h, w), floats as they are, uint8 and uint16 as shares of their largest.

    Raises:
        FileError: the file cannot be read, or what is in it is no such array.
        TypeError: an array of another dtype.
        ValueError: another shape, or values beyond 0 to 1.
    """
    if isinstance(given, np.ndarray):
        return _checked(given)
    path = Path(given)
    if path.suffix.lower() not in SUFFIXES:
        raise FileError(
            f"{path}: expected a name that ends in {' or '.join(SUFFIXES)}, got {path.suffix!r}"
        )
    data = file_bytes(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of pictures larger than most
            if path.suffix.lower() == ".npy":
                values = np.load(io.BytesIO(data), allow_pickle=False)
            else:
                values = _picture(data)
        return _checked(np.asarray(values))
    except Exception as error:  # third-party readers raise whatever they like on a broken file
        text = " ".join(str(error).split()) or type(error).__name__
        if not isinstance(error, (ValueError, TypeError)):
            text = f"not a readable {path.suffix.lower()} file: {text}"
        raise FileError(f"{path}: {text[:300]}") from error


def _picture(data: bytes) -> NDArray[Any]:
    from PIL import Image

    image = Image.open(io.BytesIO(data), formats=["PNG"])
    if image.mode.startswith("I"):  # 16 bits of grey, by some versions as 32
        return np.asarray(image).astype(np.uint16)
    return np.asarray(image.convert("L"))


def _checked(values: NDArray[Any]) -> Floats:
    if values.ndim != 2 or not values.size:
        raise ValueError(f"height_map: expected (h, w) values, got shape {values.shape}")
    if values.dtype in WHOLE:
        return (values / WHOLE[values.dtype]).astype(np.float32)
    if values.dtype.kind != "f":
        raise TypeError(f"height_map: expected floats, uint8 or uint16, got {values.dtype}")
    low, high = float(values.min()), float(values.max())
    if not (low >= 0 and high <= 1):
        raise ValueError(f"height_map: expected values of 0 to 1, got {low:g} to {high:g}")
    return np.ascontiguousarray(values, np.float32)
