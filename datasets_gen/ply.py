"""PLY files: the format of the scans.

Read here and not by trimesh, which refuses binary files that mix triangles and quads (what Blender writes)
and takes a text file that ends early for a smaller mesh.
"""

from __future__ import annotations

import struct
import warnings
from collections import defaultdict
from collections.abc import Mapping
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh

_TYPES = {
    "char": "b", "int8": "b", "uchar": "B", "uint8": "B",
    "short": "h", "int16": "h", "ushort": "H", "uint16": "H",
    "int": "i", "int32": "i", "uint": "I", "uint32": "I",
    "float": "f", "float32": "f", "double": "d", "float64": "d",
}  # fmt: skip
"""The letters mean the same to numpy and to struct."""
_BYTE_ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}
_UVS = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"))
_NORMALS, _COLOURS = ("nx", "ny", "nz"), ("red", "green", "blue")
_TAGS = ("tension", "sharpness", "bias")
ATTRIBUTES = {"normals": (_NORMALS,), "uvs": _UVS, "colours": (_COLOURS,), "tags": (_TAGS,)}
"""Properties of vertices that come along, any one set of each."""


class _Property(NamedTuple):
    name: str
    kind: str
    length_kind: str | None = None  # of a list's length; None for a plain value


Properties = tuple[_Property, ...]


def header(data: bytes) -> tuple[str, dict[str, tuple[int, Properties]], int]:
    """Encoding; count and properties of each element, in file order; where the body starts."""
    end = data.find(b"end_header")
    body = data.find(b"\n", end) + 1
    if data[:3] != b"ply":
        raise ValueError("expected a PLY file, got no 'ply' in its first line")
    if end < 0 or not body:
        raise ValueError("truncated: expected data after 'end_header', got the end of the file")
    encoding, elements, name = "", {}, ""
    for line in data[3:end].decode("latin-1").splitlines():
        try:
            match line.split():
                case [] | ["comment" | "obj_info", *_]:
                    pass
                case ["format", encoding, _] if encoding in _BYTE_ORDERS:
                    pass
                case ["element", name, count] if int(count) >= 0 and name not in elements:
                    elements[name] = (int(count), ())
                case ["property", *kinds, property_name] if len(kinds) in (1, 3):
                    order = _BYTE_ORDERS[encoding]
                    codes = [order + _TYPES[kind] for kind in reversed(kinds) if kind != "list"]
                    count, before = elements[name]
                    elements[name] = (count, (*before, _Property(property_name, *codes)))
                case _:
                    raise ValueError
        except (ValueError, LookupError, TypeError):
            raise ValueError(f"expected a PLY header line, got {line.strip()!r}") from None
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


@cache
def row_layout(properties: Properties, lengths: tuple[int, ...]) -> np.dtype:
    """A row whose lists have these lengths; `name#` is the length that stands before the list `name`."""
    fields, left = [], list(lengths)
    for name, kind, length_kind in properties:
        if length_kind:
            fields += [(name + "#", length_kind), (name, kind, (left.pop(0),))]
        else:
            fields.append((name, kind))
    return np.dtype(fields)


def _lengths(properties: Properties, body: bytes, at: int) -> tuple[int, ...]:
    """Lengths of the lists of the row at a byte."""
    found = []
    for _, kind, length_kind in properties:
        if length_kind:
            found.append(int(struct.unpack_from(length_kind, body, at)[0]))
            at += struct.calcsize(length_kind) + found[-1] * struct.calcsize(kind)
        else:
            at += struct.calcsize(kind)
    return tuple(found)


Rows = list[tuple[NDArray[np.int64], NDArray]]
"""Row numbers and a structured array, for each layout that occurs."""


def _rows(properties: Properties, count: int, body: bytes, at: int) -> tuple[Rows, int]:
    """The rows of an element from a byte on, and the byte after them."""
    if not count or not properties:
        return [(np.arange(0), np.zeros(0, [(p.name, "f8") for p in properties]))], at
    layout = row_layout(properties, _lengths(properties, body, at))
    lists = [name for name in layout.fields or () if name.endswith("#")]
    end = at + count * layout.itemsize
    if end <= len(body) or not lists:
        rows = np.frombuffer(body, layout, count, at)
        if all((rows[name] == rows[name][0]).all() for name in lists):
            return [(np.arange(count), rows)], end
    # lists of different lengths: where each row starts is known only from the one before
    found: dict[np.dtype, list[tuple[int, int]]] = defaultdict(list)
    for row in range(count):
        layout = row_layout(properties, _lengths(properties, body, at))
        found[layout].append((row, at))
        at += layout.itemsize
    if at > len(body):
        raise ValueError
    bytes_, rows = np.frombuffer(body, "u1"), []
    for layout, places in found.items():
        numbers, starts = np.array(places).T
        rows.append(
            (numbers, bytes_[starts[:, None] + np.arange(layout.itemsize)].view(layout)[:, 0])
        )
    return rows, at


def _fans(rows: Rows, name: str) -> NDArray:
    """Polygons as triangle fans from their first corner, in file order; those of two corners or less vanish."""
    if len(rows) == 1 and (corners := rows[0][1][name]).shape[1:] == (3,):
        return corners if corners.dtype.kind in "iu" else corners.astype(np.int64)
    triangles, order = [np.zeros((0, 3), np.int64)], [np.zeros(0, np.int64)]
    for numbers, table in rows:
        corners = table[name].astype(np.int64)
        for last in range(2, corners.shape[1]):
            triangles.append(corners[:, [0, last - 1, last]])
            order.append(numbers)
    return np.concatenate(triangles)[np.argsort(np.concatenate(order), kind="stable")]


def ply_counts(data: bytes) -> tuple[int, int]:
    """Vertices and faces that a PLY header declares; `data` is the start of a file, 64 KiB are enough."""
    _, elements, _ = header(data[: 1 << 16])
    return elements.get("vertex", (0, ()))[0], elements.get("face", (0, ()))[0]


def parse_ply(data: bytes) -> TriangleMesh:
    """The mesh in a PLY file: ASCII or binary of either byte order, polygons split into fans.

    Normals (nx ny nz), uvs (s t, u v or texture_u texture_v), colours (red green blue) and tags (tension
    sharpness bias) of the vertices come along; other properties are skipped.

    Raises:
        ValueError: not PLY, truncated, no vertices declared, or a bad value.
    """
    encoding, elements, at = header(data)
    kinds = {p.name: p.kind for p in elements.get("vertex", (0, ()))[1]}
    if not {"x", "y", "z"} <= set(kinds):
        raise ValueError("expected vertices with x, y and z, got none: no mesh in it")
    if "face" not in elements and "tristrips" in elements:
        raise ValueError("expected faces, got triangle strips")
    if encoding == "ascii":  # from here on a binary file of doubles
        data, at = numbers_in(data[at:]).tobytes(), 0
    tables: dict[str, Rows] = {}
    for element, (count, properties) in elements.items():
        if encoding == "ascii":
            properties = tuple(_Property(p.name, "d", p.length_kind and "d") for p in properties)
        try:
            tables[element], at = _rows(properties, count, data, at)
        except (ValueError, OverflowError, struct.error):
            raise ValueError(
                f"truncated: expected {count} rows of {element!r}, got fewer"
            ) from None
    if len(tables["vertex"]) > 1:
        raise ValueError("expected vertices of one layout, got lists of different lengths")
    vertex = tables["vertex"][0][1]

    def columns(names: tuple[str, ...]) -> NDArray | None:
        return np.stack([vertex[n] for n in names], axis=1) if set(names) <= set(kinds) else None

    colours = columns(_COLOURS)
    if colours is not None and (kind := np.dtype(kinds["red"])).kind != "f":
        colours = colours / float(np.iinfo(kind).max)
    count, properties = elements.get("face", (0, ()))
    indices = [p.name for p in properties if p.name in ("vertex_indices", "vertex_index")]
    if count and not indices:
        raise ValueError(f"expected faces with vertex_indices, got {[p.name for p in properties]}")
    triangles = _fans(tables["face"], indices[0]) if count else np.zeros((0, 3), np.uint32)
    uvs = next((found for pair in _UVS if (found := columns(pair)) is not None), None)
    positions = columns(("x", "y", "z"))
    assert positions is not None
    return TriangleMesh(positions, triangles, columns(_NORMALS), uvs, colours, columns(_TAGS))


def ply_file(mesh: TriangleMesh) -> bytes:
    """A binary little-endian PLY file of `mesh`, with points in double where it has an origin; colours have 8 bits."""
    columns = vertex_columns(mesh.points, mesh.normals, mesh.uvs, mesh.tags, mesh.colours)
    kinds = {name: values.dtype for name, values in columns.items()}
    head = ply_head(kinds, mesh.vertex_count, mesh.triangle_count)
    return head + ply_vertices(columns) + ply_faces(mesh.triangles)


def vertex_columns(
    points: NDArray[np.floating],
    normals: NDArray[np.float32] | None = None,
    uvs: NDArray[np.float32] | None = None,
    tags: NDArray[np.float32] | None = None,
    colours: NDArray[np.float32] | None = None,
) -> dict[str, NDArray]:
    """The properties of vertices by name, in the order of a file; colours have 8 bits."""
    columns: dict[str, NDArray] = dict(zip("xyz", points.T, strict=True))
    bytes_ = None if colours is None else np.rint(np.clip(colours, 0, 1) * 255).astype(np.uint8)
    for names, values in ((_NORMALS, normals), (_UVS[0], uvs), (_TAGS, tags), (_COLOURS, bytes_)):
        if values is not None:
            columns |= dict(zip(names, values.T, strict=True))
    return columns


def ply_vertices(columns: Mapping[str, NDArray]) -> bytes:
    """Rows of vertices, of what `vertex_columns` gives."""
    rows = np.empty(
        len(columns["x"]), [(name, v.dtype.newbyteorder("<")) for name, v in columns.items()]
    )
    for name, values in columns.items():
        rows[name] = values
    return rows.tobytes()


def ply_head(kinds: Mapping[str, np.dtype], vertex_count: int, triangle_count: int) -> bytes:
    """The header of a binary little-endian PLY file whose vertices have these properties: float, double or uchar."""
    words = {"f": "float", "d": "double", "B": "uchar"}
    properties = [f"property {words[kind.char]} {name}" for name, kind in kinds.items()]
    head = [
        "ply", "format binary_little_endian 1.0",
        f"element vertex {vertex_count}", *properties,
        f"element face {triangle_count}", "property list uchar int vertex_indices",
        "end_header",
    ]  # fmt: skip
    return "\n".join([*head, ""]).encode()


def ply_faces(triangles: NDArray[np.integer]) -> bytes:
    """Rows of faces, of triangles (m, 3), as `ply_head` declares them."""
    faces = np.empty(len(triangles), [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, triangles
    return faces.tobytes()
