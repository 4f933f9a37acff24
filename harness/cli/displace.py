"""What `--displace` means: a kind with its numbers, or a file that raises the surface."""

from __future__ import annotations

from pathlib import Path
from typing import Any

FORMS = "[KIND:]HEIGHT[,WAVES], PICTURE:HEIGHT[,BIAS] or FUNCTION.cl"
FUNCTION = ".cl"
PICTURES = (".png", ".npy")


def displacement(text: str) -> dict[str, Any]:
    """`0.02`, `0.02,8`, `perlin:0.02,8`, `bumps.png:0.02` or `bumps.cl` as options of the API.

    Raises:
        ValueError: another form; FileError where a file cannot be read.
    """
    if Path(text).suffix.lower() == FUNCTION:
        return {"displacement": "function", "function": text_of(Path(text))}
    kind, _, numbers = text.rpartition(":")
    mapped = Path(kind).suffix.lower() in PICTURES
    names = ("amplitude", "map_bias" if mapped else "waves")
    try:
        found = [float(word) for word in numbers.split(",")]
        options: dict[str, Any] = dict(zip(names[: len(found)], found, strict=True))
    except ValueError:
        raise ValueError(f"displace: expected {FORMS}, got {text!r}") from None
    if mapped:
        return options | {"displacement": "height_map", "height_map": kind}
    return options | ({"displacement": kind} if kind else {})


def text_of(path: Path) -> str:
    """The OpenCL C in a file.

    Raises:
        FileError: it cannot be read, or is not UTF-8.
    """
    from lodbench.datasets_gen.read import FileError, file_bytes

    try:
        return file_bytes(path).decode()
    except UnicodeDecodeError:
        raise FileError(f"{path}: expected OpenCL C in UTF-8, got other bytes") from None
