"""Pictures as arrays: written to files, and compared."""

from __future__ import annotations

import io
from os import PathLike

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.files import write_file

Image = NDArray[np.uint8]


def write_png(path: str | PathLike[str], image: Image) -> None:
    """Write (height, width, 3) or (height, width) uint8 as a PNG file.

    Raises:
        TypeError: another dtype.
        ValueError: another shape.
        OSError: the file cannot be written.
    """
    write_file(path, png_bytes(image))


def gif_bytes(images: Image, seconds: float) -> bytes:
    """A GIF that shows (n, height, width, 3) uint8 again and again, all of them in so many seconds."""
    from PIL import Image as Pillow

    first, *others = (Pillow.fromarray(image).quantize(256) for image in images)
    packed = io.BytesIO()
    each = max(round(1000 * seconds / len(images)), 20)  # ms; viewers slow down what is shorter
    first.save(packed, "GIF", save_all=True, append_images=others, duration=each, loop=0)
    return packed.getvalue()


def png_bytes(image: Image) -> bytes:
    """The PNG file of an image; errors as `write_png`."""
    image = np.asarray(image)
    if image.dtype != np.uint8:
        raise TypeError(f"image: expected uint8, got {image.dtype}")
    if image.ndim not in (2, 3) or (image.ndim == 3 and image.shape[2] != 3) or not image.size:
        raise ValueError(f"image: expected (height, width, 3), got shape {image.shape}")
    from PIL import Image as Pillow

    packed = io.BytesIO()
    Pillow.fromarray(image).save(packed, format="PNG")
    return packed.getvalue()


def _difference(a: Image, b: Image) -> NDArray[np.float64]:
    a, b = np.asarray(a), np.asarray(b)
    if a.shape != b.shape or not a.size:
        raise ValueError(f"a, b: expected two images of one shape, got {a.shape} and {b.shape}")
    return a.astype(np.float64) - b.astype(np.float64)


def psnr(a: Image, b: Image, where: NDArray[np.bool_] | None = None) -> float:
    """Peak signal-to-noise ratio, dB: 10 log10(255^2 / mean squared difference); infinite for equal images.

    Args:
        a: (height, width, 3) uint8.
        b: of the same shape.
        where: (height, width), the pixels that count; None: all.

    Raises:
        ValueError: two shapes, or no pixel that counts.
    """
    difference = _difference(a, b)
    if where is not None:
        difference = difference[where]
        if not difference.size:
            raise ValueError("where: expected at least one pixel that counts, got none")
    mean = float((difference**2).mean())
    return float("inf") if mean == 0 else 10 * float(np.log10(255.0**2 / mean))


def mean_absolute_difference(a: Image, b: Image) -> float:
    """Mean over pixels and channels of the difference, in levels of 0..255.

    Raises:
        ValueError: two shapes.
    """
    return float(np.abs(_difference(a, b)).mean())
