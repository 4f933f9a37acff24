"""What a mesh file is and has, told from its bytes: the format, and what a TriangleMesh leaves out of it."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from lodbench.datasets_gen import ply


def format_of(data: bytes) -> str | None:
    """The suffix that a file of these bytes should have, of a mesh or `.npz`; None where no format is like it."""
    start = data[:1024].lstrip()
    if data[:3] == b"ply":
        return ".ply"
    if data[:4] == b"glTF":
        return ".glb"
    if data[:4] == b"PK\x03\x04":
        return ".npz"
    if len(data) >= 84 and len(data) == 84 + 50 * int.from_bytes(data[80:84], "little"):
        return ".stl"  # before the text of that name: binary files may begin with it too
    if start[:5].lower() == b"solid":
        return ".stl"
    if start[:1] == b"{":
        return ".gltf"
    if re.match(rb"(?:#[^\n]*\s+)*(?:ST)?C?N?OFF\b", start):
        return ".off"
    if b"\0" not in start and re.search(rb"^[ \t]*v[ \t]", data, re.MULTILINE):
        return ".obj"
    return None


def extras(data: bytes, path: Path) -> list[str]:
    """What the file has beside points and triangles, by name, whether a TriangleMesh takes it or not.

    Args:
        data: the whole file, one that can be read.
        path: its suffix says the format; the material files that it names are looked for beside it.
    """
    found = dict.fromkeys(_EXTRAS[path.suffix.lower()](data, path))
    return list(found)


def _of_ply(data: bytes, path: Path) -> Iterable[str]:
    _, elements, body = ply.header(data)
    known = {"x", "y", "z"}
    for name, sets in ply.ATTRIBUTES.items():
        for names in sets:
            if set(names) <= {p.name for p in elements["vertex"][1]}:
                known |= set(names)
                yield name
    for element, (count, properties) in elements.items():
        if element not in ("vertex", "face"):
            if count:
                yield element
            continue
        names = [p.name for p in properties if count and p.name not in known]
        if element == "face" and {"red", "green", "blue"} <= set(names):
            yield "face colours"
            names = [name for name in names if name not in ("red", "green", "blue", "alpha")]
        for name in names:
            if name == "texcoord":
                yield "uvs"
            elif not (element == "face" and name in ("vertex_indices", "vertex_index")):
                yield f"{element} {name}"
    if re.search(rb"^comment TextureFile", data[:body], re.MULTILINE):
        yield "textures"


def _of_obj(data: bytes, path: Path) -> Iterable[str]:
    for name, form in (
        ("colours", rb"v([ \t]+[^\s#]+){6}"),
        ("normals", rb"vn[ \t]"),
        ("uvs", rb"vt[ \t]"),
        ("materials", rb"(?:usemtl|mtllib)\b"),
        ("groups", rb"[og][ \t]+\S"),
        ("smoothing groups", rb"s[ \t]+[1-9]"),
        ("lines", rb"l[ \t]"),
    ):
        if re.search(rb"^[ \t]*" + form, data, re.MULTILINE):
            yield name
    for library in re.findall(rb"^[ \t]*mtllib[ \t]+([^\r\n]+)", data, re.MULTILINE):
        try:
            materials = (path.parent / library.decode().strip()).read_bytes()
        except (OSError, ValueError):
            continue
        if re.search(rb"^[ \t]*map_", materials, re.MULTILINE):
            yield "textures"


def _of_stl(data: bytes, path: Path) -> Iterable[str]:
    count = int.from_bytes(data[80:84], "little")
    if len(data) != 84 + 50 * count:
        if data.lower().count(b"endsolid") > 1:
            yield "groups"
    elif np.frombuffer(data, np.uint8)[84:].reshape(count, 50)[:, 48:].any():
        yield "face colours"


def _of_off(data: bytes, path: Path) -> Iterable[str]:
    data = re.sub(rb"#[^\n]*", b"", data)
    match = re.match(rb"\s*(ST)?(C)?(N)?OFF\s+(\d+)\s+(\d+)[^\n]*", data)
    assert match is not None  # it has been read
    for present, name in zip(match.groups()[:3], ("uvs", "colours", "normals"), strict=True):
        if present:
            yield name
    rows = [row for row in data[match.end() :].splitlines() if row.strip()]
    faces = (row.split() for row in rows[int(match[4]) : int(match[4]) + int(match[5])])
    if any(len(row) > 1 + int(row[0]) for row in faces):
        yield "face colours"


def _of_gltf(data: bytes, path: Path) -> Iterable[str]:
    if data[:4] == b"glTF":
        data = data[20 : 20 + int.from_bytes(data[12:16], "little")]
    document: dict[str, Any] = json.loads(data.decode("utf-8", "replace").rstrip("\0 \r\n"))
    meshes = document.get("meshes", [])
    primitives = [part for mesh in meshes for part in mesh.get("primitives", [])]
    attributes = " ".join(name for part in primitives for name in part.get("attributes", {}))
    for sign, name in (
        ("NORMAL", "normals"), ("TEXCOORD", "uvs"), ("COLOR", "colours"), ("TANGENT", "tangents"),
    ):  # fmt: skip
        if sign in attributes:
            yield name
    if any(part.get("targets") for part in primitives):
        yield "morph targets"
    if sum("mesh" in node for node in document.get("nodes", [])) > 1:
        yield "groups"
    for key in ("materials", "textures", "skins", "animations", "cameras"):
        if document.get(key):
            yield key


_EXTRAS: dict[str, Callable[[bytes, Path], Iterable[str]]] = {
    ".ply": _of_ply, ".obj": _of_obj, ".stl": _of_stl, ".off": _of_off, ".gltf": _of_gltf,
    ".glb": _of_gltf,
}  # fmt: skip
