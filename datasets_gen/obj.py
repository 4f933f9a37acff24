"""OBJ files with normals or texture coordinates, which name a point, a uv and a normal for each corner of a face.

Read here and not by trimesh, which numbers the points anew and needs materials for texture coordinates.
"""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray
from trimesh.grouping import unique_rows

from lodbench.datasets_gen.ply import numbers_in
from lodbench.datasets_gen.surfaces import TriangleMesh

_CORNER = {
    "v": rb"(?<!\S)([+-]?\d+)(?:/[+-]?\d*){0,2}(?!\S)",
    "vt": rb"(?<!\S)[+-]?\d+/([+-]?\d+)(?:/[+-]?\d*)?(?!\S)",
    "vn": rb"(?<!\S)[+-]?\d+/[+-]?\d*/([+-]?\d+)(?!\S)",
}
"""The number of each in a corner: 1, 1/2, 1//3 or 1/2/3."""


def _table(data: bytes, kind: str) -> NDArray[np.float64]:
    """The rows of `v`, `vt` or `vn`.

    Raises:
        ValueError: of different lengths, or no numbers.
    """
    lines = re.findall(rb"^ *" + kind.encode() + rb" +([^\n]*)", data, re.MULTILINE)
    found = numbers_in(b" ".join(lines))
    return found.reshape(len(lines), -1) if lines else np.zeros((0, 3))


def _fans(sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Triangles, (m, 3), as numbers of corners, of polygons of so many corners, in order."""
    of_each = np.maximum(sizes - 2, 0)
    first = np.repeat(np.cumsum(sizes) - sizes, of_each)
    step = np.arange(of_each.sum()) - np.repeat(np.cumsum(of_each) - of_each, of_each)
    return np.stack([first, first + step + 1, first + step + 2], axis=1)


def parse_obj(data: bytes) -> TriangleMesh | None:
    """The mesh with the uvs and normals that every corner has; None where there is neither, or something is amiss.

    A point keeps its number; where its corners have several uvs or normals, those beyond the first follow after all
    points, in the order of theirs. Numbers and lines are as the format has them, polygons become fans.

    Args:
        data: the file with line ends of one character, no continued lines and no tabulators.
    """
    if not re.search(rb"^ *v[tn] ", data, re.MULTILINE):
        return None
    data = re.sub(rb"#[^\n]*", b"", data)
    try:
        return _parsed(data)
    except (ValueError, IndexError):
        return None


def _parsed(data: bytes) -> TriangleMesh | None:
    faces = re.findall(rb"^ *f +([^\n]*)", data, re.MULTILINE)
    sizes = np.array([len(face.split()) for face in faces], np.int64)
    text, total = b"\n".join(faces), int(sizes.sum())
    tables: dict[str, NDArray[np.floating]] = {}
    numbers: dict[str, NDArray[np.int64]] = {}
    for kind, form in _CORNER.items():
        found = re.findall(form, text)
        if len(found) == total:
            tables[kind] = _table(data, kind)
            numbers[kind] = _from_zero(np.array(found, object).astype(np.int64), len(tables[kind]))
    if not total or "v" not in tables or len(tables) < 2 or tables["v"].shape[1] not in (3, 6):
        return None
    if b"-" in text and max(data.rfind(b"\nv"), data.rfind(b"\n v")) > data.find(b"\nf"):
        return None  # relative numbers count from what stands before them
    corner, kinds = numbers.pop("v"), list(numbers)
    parts = np.zeros(total, np.int64)  # a number for each pair of a uv and a normal
    for kind in kinds:
        values = tables[kind][:, : 2 if kind == "vt" else 3].astype(np.float32) + np.float32(0)
        if values.shape[1] != (2 if kind == "vt" else 3) or not np.isfinite(values).all():
            return None
        tables[kind] = values
        same = unique_rows(np.ascontiguousarray(values).view(np.int32))[1]
        pairs = parts * len(values) + same[numbers[kind]]
        parts = np.unique(pairs, return_inverse=True)[1].ravel()
    keys, first, of_corner = np.unique(
        corner * (parts.max() + 1) + parts, return_index=True, return_inverse=True
    )
    points = tables["v"]
    order = np.lexsort((first, corner[first]))
    owner = corner[first][order]
    again = np.r_[False, owner[1:] == owner[:-1]]
    number = np.empty(len(keys), np.int64)
    number[order] = np.where(again, len(points) + np.cumsum(again) - 1, owner)
    points = np.concatenate([points, points[owner[again]]])
    attributes = {}
    for kind, name, none in (("vt", "uvs", (0.0, 0.0)), ("vn", "normals", (0.0, 0.0, 1.0))):
        if kind in kinds:
            values = np.tile(np.array(none, np.float32), (len(points), 1))
            values[number] = tables[kind][numbers[kind][first]]
            attributes[name] = values
    if points.shape[1] == 6:
        attributes["colours"] = points[:, 3:]
    return TriangleMesh(points[:, :3], number[of_corner.ravel()][_fans(sizes)], **attributes)


def _from_zero(numbers: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """Rows of a table of `count`, from numbers that begin at 1, or at -1 from its end.

    Raises:
        ValueError: out of range.
    """
    rows = np.where(numbers < 0, numbers + count, numbers - 1)
    if len(rows) and (not numbers.all() or rows.min() < 0 or rows.max() >= count):
        raise ValueError
    return rows
