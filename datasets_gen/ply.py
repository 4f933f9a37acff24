"""PLY files: the format of the scans, read strictly (every byte accounted for) and written in binary."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1",
    "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
_INDICES = ("vertex_indices", "vertex_index")
_UVS = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"))
_TAGS = ("sharpness", "bias", "tension")
_HEADER_LIMIT = 1 << 16


@dataclass(frozen=True)
class _Property:
    name: str
    dtype: str
    count_dtype: str | None  # of a list's length; None for a plain value


@dataclass(frozen=True)
class _Element:
    name: str
    count: int
    properties: tuple[_Property, ...]


def _header(data: bytes) -> tuple[str, list[_Element], int]:
    """Encoding, elements and where the body starts."""
    if data[:3] != b"ply":
        raise ValueError("expected a PLY file, got no 'ply' in its first line")
    end = data.find(b"end_header")
    if end < 0:
        raise ValueError("truncated: expected 'end_header', got the end of the file")
    body = data.find(b"\n", end) + 1
    if not body:
        raise ValueError("truncated: expected data after 'end_header', got the end of the file")
    encoding = ""
    elements: list[_Element] = []
    for line in data[:end].decode("latin-1").splitlines()[1:]:
        words = line.split()
        try:
            if not words or words[0] in ("comment", "obj_info"):
                continue
            if words[0] == "format":
                encoding = words[1]
            elif words[0] == "element":
                elements.append(_Element(words[1], int(words[2]), ()))
            elif words[0] == "property":
                last = elements[-1]
                value = (
                    _Property(words[4], _TYPES[words[3]], _TYPES[words[2]])
                    if words[1] == "list"
                    else _Property(words[2], _TYPES[words[1]], None)
                )
                elements[-1] = _Element(last.name, last.count, (*last.properties, value))
            else:
                raise ValueError
        except (ValueError, LookupError):
            raise ValueError(f"expected a PLY header line, got {line.strip()!r}") from None
    if encoding not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise ValueError(f"expected a PLY format that is known, got {encoding!r}")
    if any(element.count < 0 for element in elements):
        raise ValueError("expected element counts of at least 0, got a negative one")
    return encoding, elements, body


def numbers_in(text: bytes, dtype: type = np.float64) -> NDArray:
    """The numbers in a text of numbers parted by white space; ValueError where it holds anything else."""
    if not text or text.isspace():
        return np.zeros(0, dtype)
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)
        try:
            return np.fromstring(text, dtype, sep=" ")
        except (ValueError, DeprecationWarning):
            raise ValueError("expected numbers, got something else among them") from None


class _Body:
    """The values after the header, taken element by element."""

    def __init__(self, data: bytes, start: int, encoding: str) -> None:
        self.order = ">" if encoding == "binary_big_endian" else "<"
        self.ascii = encoding == "ascii"
        # ascii: all words as numbers, one unit each; binary: bytes
        self.values = numbers_in(data[start:]) if self.ascii else np.frombuffer(data, "u1")
        self.at = 0 if self.ascii else start

    def rows(self, element: _Element) -> dict[str, NDArray]:
        """Columns of an element by name; a list gives `name` (its values end to end) and `name#` (lengths)."""
        if element.count == 0 or not element.properties:
            return {}
        block, done = self._block(element)
        parts = [block] if done == element.count else [block, self._walk(element, done)]
        return {
            name: np.concatenate([part[name].reshape(-1) for part in parts]) for name in parts[0]
        }

    def _units(self, dtype: str) -> int:
        return 1 if self.ascii else np.dtype(dtype).itemsize

    def _take(self, at: int, dtype: str, count: int, element: _Element, row: int):
        end = at + count * self._units(dtype)
        if count < 0 or end > len(self.values):
            raise ValueError(
                f"truncated: expected {element.count} rows of {element.name!r}, got {row}"
            )
        found = self.values[at:end]
        return (found if self.ascii else found.view(self.order + dtype)), end

    def _block(self, element: _Element) -> tuple[dict[str, NDArray], int]:
        """The first rows, as far as their lists are as long as in the first one, and their number."""
        fields: list[tuple[str, str, int]] = []
        at = self.at
        for p in element.properties:
            width = 1
            if p.count_dtype:
                length, at = self._take(at, p.count_dtype, 1, element, 0)
                width = int(length[0])
                fields.append((p.name + "#", p.count_dtype, 1))
            fields.append((p.name, p.dtype, width))
            _, at = self._take(at, p.dtype, width, element, 0)
        stride = at - self.at
        rows = min(element.count, (len(self.values) - self.at) // stride)
        table = self.values[self.at : self.at + rows * stride].reshape(rows, stride)
        columns: dict[str, NDArray] = {}
        start = 0
        for name, dtype, width in fields:
            end = start + width * self._units(dtype)
            part = table[:, start:end]
            # a column of bytes is copied before its bytes are read as numbers
            columns[name] = part if self.ascii else part.copy().view(self.order + dtype)
            start = end
        for name, column in columns.items():
            if name.endswith("#"):
                other = np.flatnonzero(column[:rows, 0] != column[0, 0])
                rows = int(other[0]) if len(other) else rows
        self.at += rows * stride
        return {name: column[:rows] for name, column in columns.items()}, rows

    def _walk(self, element: _Element, first: int) -> dict[str, NDArray]:
        """Row by row from row `first`, for polygons of different sizes."""
        parts: dict[str, list[NDArray]] = {}
        for row in range(first, element.count):
            for p in element.properties:
                count = 1
                if p.count_dtype:
                    length, self.at = self._take(self.at, p.count_dtype, 1, element, row)
                    count = int(length[0])
                    parts.setdefault(p.name + "#", []).append(length)
                values, self.at = self._take(self.at, p.dtype, count, element, row)
                parts.setdefault(p.name, []).append(values)
        return {name: np.concatenate(values) for name, values in parts.items()}


def fans(lengths: NDArray[np.integer], indices: NDArray[np.integer]) -> NDArray[np.int64]:
    """Polygons as triangle fans from their first corner, (m, 3) int64; those of two corners or less vanish.

    `lengths` (n,) are the corners of each polygon, `indices` (sum,) the corners one after another.
    """
    lengths = lengths.astype(np.int64)
    indices = indices.astype(np.int64)
    if (lengths == 3).all():
        return indices.reshape(-1, 3)
    counts = np.maximum(lengths - 2, 0)
    start = np.repeat(np.cumsum(lengths) - lengths, counts)
    step = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return indices[np.stack([start, start + step + 1, start + step + 2], axis=1)]


def ply_counts(data: bytes) -> tuple[int, int]:
    """Vertices and faces that a PLY header declares; `data` is the start of a file, 64 KiB are enough."""
    _, elements, _ = _header(data[:_HEADER_LIMIT])
    counts = {element.name: element.count for element in elements}
    return counts.get("vertex", 0), counts.get("face", 0)


def parse_ply(data: bytes) -> TriangleMesh:
    """The mesh in a PLY file: ASCII or binary of either byte order, polygons split into fans.

    Normals (nx ny nz), uvs (s t, u v or texture_u texture_v), colours (red green blue) and tags (sharpness
    bias tension) of the vertices come along; other properties are skipped.

    Raises:
        ValueError: not PLY, truncated, no vertices declared, or a bad value.
    """
    encoding, elements, start = _header(data)
    body = _Body(data, start, encoding)
    tables = {element.name: body.rows(element) for element in elements}
    declared = {p.name: p for e in elements if e.name == "vertex" for p in e.properties}
    if not {"x", "y", "z"} <= set(declared):
        raise ValueError("expected vertices with x, y and z, got none: no mesh in it")
    if any(e.name == "tristrips" and e.count for e in elements):
        raise ValueError("expected faces, got triangle strips")
    vertex, face = tables["vertex"], tables.get("face", {})
    if not vertex:
        vertex = {name: np.zeros(0) for name in declared}

    def columns(*names: str) -> NDArray | None:
        if not all(name in vertex for name in names):
            return None
        return np.stack([vertex[name] for name in names], axis=1)

    colours = columns("red", "green", "blue")
    if colours is not None and declared["red"].dtype[0] != "f":
        colours = colours / float(np.iinfo(declared["red"].dtype).max)
    name = next((name for name in _INDICES if name in face), None)
    if face and name is None:
        raise ValueError(f"expected faces with vertex_indices, got {sorted(face)}")
    triangles = fans(face[name + "#"], face[name]) if name else np.zeros((0, 3), np.uint32)
    uvs = next((found for pair in _UVS if (found := columns(*pair)) is not None), None)
    positions = columns("x", "y", "z")
    assert positions is not None
    return TriangleMesh(
        positions, triangles, columns("nx", "ny", "nz"), uvs, colours, columns(*_TAGS)
    )


def ply_parts(mesh: TriangleMesh) -> list[bytes]:
    """A binary little-endian PLY file of `mesh`, in parts; colours are rounded to 8 bits."""
    columns: list[tuple[str, str, NDArray]] = []
    for names, values in (
        (("x", "y", "z"), mesh.positions),
        (("nx", "ny", "nz"), mesh.normals),
        (_UVS[0], mesh.uvs),
        (_TAGS, mesh.tags),
    ):
        if values is not None:
            columns += [(n, "float", values[:, i]) for i, n in enumerate(names)]
    if mesh.colours is not None:
        bytes_ = np.rint(np.clip(mesh.colours, 0, 1) * 255).astype(np.uint8)
        columns += [(n, "uchar", bytes_[:, i]) for i, n in enumerate(("red", "green", "blue"))]
    vertices = np.zeros(mesh.vertex_count, [(n, "<" + _TYPES[kind]) for n, kind, _ in columns])
    for name, _, values in columns:
        vertices[name] = values
    faces = np.zeros(mesh.triangle_count, [("n", "u1"), ("corners", "<u4", (3,))])
    faces["n"] = 3
    faces["corners"] = mesh.triangles
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {mesh.vertex_count}"]
    header += [f"property {kind} {name}" for name, kind, _ in columns]
    header += [f"element face {mesh.triangle_count}"]
    header += ["property list uchar uint vertex_indices", "end_header", ""]
    return ["\n".join(header).encode(), vertices.tobytes(), faces.tobytes()]
