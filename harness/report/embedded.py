"""Pictures within a page: those of a run's `images/`, made small, in their order and by the table they belong to."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

from lodbench.harness.record.foreign import PICTURE_FIELDS, read_json
from lodbench.harness.report.methods import SERIES as RIVALS

IMAGES = (".png", ".jpg", ".jpeg", ".webp")
WIDTH = 448  # pixels of a picture in the page, twice what it takes on a screen
LARGE, SMALL = 576, 320  # of one of several levels, which is shown alone, and of one of a dataset
QUALITIES = (70, 50, 30)  # of WebP; the first with which all pictures fit
ROOM = 2_000_000  # letters of all of them, so that the page stays under 5 MB
MOST_PIXELS = 50_000_000  # of a file; a larger one is none of a run's


@dataclass(frozen=True)
class Embedded:
    """A picture: what it shows, in words and short, its text as an address, and its size in pixels."""

    caption: str
    name: str
    series: str
    table: str
    level: int | None
    data: str
    width: int
    height: int


def pictures(folder: Path) -> list[Embedded]:
    """A run's pictures in the order of their list, with its captions and series; others after them, by name.

    Raises:
        ValueError: a list or a picture that is none.
    """
    folder = Path(folder) / "images"
    listed = folder / "pictures.json"
    known: dict[str, dict[str, Any]] = {}
    if listed.is_file():
        known = {each["file"]: each for each in read_json(listed, PICTURE_FIELDS)}
    order = {name: number for number, name in enumerate(known)}
    files = [path for path in folder.glob("*") if path.suffix.lower() in IMAGES]
    files.sort(key=lambda path: (order.get(path.name, len(order)), path))
    found: list[Embedded] = []
    for quality in QUALITIES:
        found = [_embedded(path, known.get(path.name, {}), quality) for path in files]
        if sum(len(one.data) for one in found) <= ROOM:
            break
    return found


def _embedded(path: Path, about: Mapping[str, Any], quality: int) -> Embedded:
    series = about.get("series", "")
    width = LARGE if "level" in about else WIDTH if series else SMALL
    data, size = _packed(path, width, quality)
    return Embedded(
        about.get("caption", path.stem.replace("_", " ")),
        about.get("name", ""),
        series,
        about.get("table", ""),
        about.get("level"),
        data,
        *size,
    )


def _packed(path: Path, width: int, quality: int) -> tuple[str, tuple[int, int]]:
    """A file's picture as a WebP at most so wide, as an address of data, and its size."""
    from PIL import Image

    try:
        with Image.open(path) as file:
            if file.width * file.height > MOST_PIXELS:
                raise ValueError(f"{file.width} x {file.height} pixels")
            picture = file.convert("RGB")
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise ValueError(f"{path}: expected a picture, got {error}") from None
    if picture.width > width:
        height = max(round(picture.height * width / picture.width), 1)
        picture = picture.resize((width, height), Image.Resampling.LANCZOS)
    packed = io.BytesIO()
    picture.save(packed, "WEBP", quality=quality, method=4)
    return f"data:image/webp;base64,{base64.b64encode(packed.getvalue()).decode()}", picture.size


def strips(found: Sequence[Embedded]) -> list[list[Embedded]]:
    """Pictures of one series together."""
    return [list(some) for _, some in groupby(found, key=lambda one: (one.series, one.table))]


def is_slider(strip: Sequence[Embedded]) -> bool:
    """Are these one thing at several levels?"""
    return len(strip) > 2 and all(one.level is not None for one in strip)


def rivals(found: Sequence[Embedded]) -> list[Embedded]:
    """The pictures of rivals at like counts, with their names in them."""
    return [one for one in found if one.series == RIVALS]
