"""Mesh files in and out: PLY, OBJ, STL, OFF, glTF and GLB, told apart by their suffix; trimesh parses most.

Reading ends in a valid TriangleMesh or in one FileError of one line. Writing is atomic: the file appears
complete under its name, or what was there before stays.
"""

from __future__ import annotations

import contextlib
import io
import logging
import os
import re
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import trimesh
from trimesh.resolvers import FilePathResolver

from lodbench.datasets_gen import files, gltf
from lodbench.datasets_gen.formats import CHAIN_WRITERS, PART_WRITERS, WRITERS
from lodbench.datasets_gen.names import FOLDERS
from lodbench.datasets_gen.obj import parse_obj
from lodbench.datasets_gen.order import welded
from lodbench.datasets_gen.ply import parse_ply
from lodbench.datasets_gen.surfaces import TriangleMesh

SUFFIXES = FOLDERS["meshes"]


class FileError(ValueError):
    """A file that cannot be read or written; the text is one line that says which and why."""


def read_mesh(path: str | os.PathLike[str]) -> TriangleMesh:
    """The mesh in a file of one of `SUFFIXES`.

    Points keep their order and stay unless the format has none to share: STL corners with equal coordinates
    become one point. The meshes of a glTF scene are moved to their places and joined; polygons are split
    into triangles. Doubles and text that lie far from zero get an origin, see TriangleMesh. The normals, uvs
    and colours of the vertices of PLY, OBJ, glTF and GLB come along, and the tags of PLY; of OBJ those that every
    corner has, and a point with several of them becomes as many vertices; of a scene those that all meshes have.

    Raises:
        FileError: no such file, a folder, an unknown suffix, a truncated or broken file, no mesh in it,
            NaN or infinity, an index out of range. No triangles is no error.
    """
    path = Path(path)
    check_suffix(path)
    return parse_mesh(file_bytes(path), path)


def file_bytes(path: Path) -> bytes:
    """The whole file.

    Raises:
        FileError: no such file, a folder, one that cannot be read.
    """
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise FileError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise FileError(f"{path}: expected a file, got a folder") from None
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror}") from None


def parse_mesh(data: bytes, path: Path) -> TriangleMesh:
    """The mesh in the bytes of a file; errors, suffix and what a glTF names beside itself come from its path.

    Raises:
        FileError: as `read_mesh`.
    """
    read = _checked_suffix(path, _READERS)
    if not data:
        raise FileError(f"{path}: the file is empty (0 bytes)")
    try:
        with _quiet():
            return read(data, path)
    except MemoryError:
        raise
    except Exception as error:  # third-party readers raise whatever they like on a broken file
        text = " ".join(str(error).split()) or type(error).__name__
        if not isinstance(error, (ValueError, TypeError)):
            text = f"not a readable {path.suffix.lower()} file: {text}"
        raise FileError(f"{path}: {text[:300]}") from error


def write_mesh(path: str | os.PathLike[str], mesh: TriangleMesh) -> None:
    """Write `mesh` in the format of the suffix, atomically.

    PLY carries everything; OBJ, glTF and GLB points, triangles, normals, uvs and colours; OFF points and triangles;
    STL triangles alone. Colours are rounded to 8 bits except in OBJ.
    A mesh with an origin keeps it: as doubles, in all their digits, or as the place of a glTF node; STL is text then.
    glTF, GLB and STL cannot hold points without triangles: these are left out.

    Raises:
        FileError: the path cannot be written, or the disk is full.
    """
    path = Path(path)
    check_writable(path)
    data = mesh_bytes(mesh, path.suffix)
    with replacing(path) as stream:
        stream.write(data)


def mesh_bytes(mesh: TriangleMesh, suffix: str) -> bytes:
    """The file of that suffix, see `write_mesh`."""
    with _quiet():
        return WRITERS[suffix.lower()](mesh)


def chain_bytes(levels: Sequence[TriangleMesh], suffix: str) -> bytes | None:
    """One file of that suffix with all levels of detail, finest first; None where the format holds one mesh alone."""
    write = CHAIN_WRITERS.get(suffix.lower())
    if write is None:
        return None
    with _quiet():
        return write(levels)


def parts_bytes(parts: Mapping[str, TriangleMesh], suffix: str) -> bytes | None:
    """One file of that suffix with all parts by name; None where the format holds one mesh alone."""
    write = PART_WRITERS.get(suffix.lower())
    if write is None:
        return None
    with _quiet():
        return write(parts)


def check_writable(path: str | os.PathLike[str]) -> None:
    """Raise FileError where `write_mesh(path, ...)` could not work: call it before long work."""
    path = Path(path)
    check_suffix(path)
    check_replaceable(path)


def check_suffix(path: Path) -> None:
    """Raise FileError where the suffix is none of `SUFFIXES`."""
    _checked_suffix(path, WRITERS)


def check_replaceable(path: Path) -> None:
    """Raise FileError where `replacing(path)` could not work, whatever the suffix."""
    if path.exists() and not path.is_file():
        raise FileError(f"{path}: expected a file to write, got a folder or a device")
    if path.exists() and not os.access(path, os.W_OK):
        raise FileError(f"{path}: the file is read-only")
    folder = path.resolve().parent
    if not folder.is_dir():
        raise FileError(f"{path}: no such folder: {folder}")
    try:
        trial = files.beside(path.resolve())
        trial.touch(exist_ok=False)
        trial.unlink()
    except OSError as error:
        raise FileError(f"{path}: cannot be written: {error.strerror}") from None


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """`files.replacing` whose error is a FileError."""
    try:
        with files.replacing(path) as stream:
            yield stream
    except OSError as error:
        raise FileError(f"{path}: cannot be written: {error.strerror or error}") from error


def write_all(contents: Mapping[Path, bytes]) -> None:
    """Write several files: each is complete before the first takes its name.

    Raises:
        FileError: one cannot be written, or the disk is full; then all are as they were, unless the names themselves
            could not be given.
    """
    with contextlib.ExitStack() as stack:
        for path, content in contents.items():
            stream = stack.enter_context(replacing(path))
            stream.write(content)
            stream.flush()


def _checked_suffix(path: Path, known: dict[str, Callable]) -> Callable:
    found = known.get(path.suffix.lower())
    if found is None:
        got = repr(path.suffix) if path.suffix else "none"
        raise FileError(f"{path}: expected a suffix of {' '.join(SUFFIXES)}, got {got}")
    return found


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Without the log lines and warnings of third-party readers: what matters becomes an error."""
    logger = logging.getLogger("trimesh")
    before = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            # text that stops being numbers midway
            warnings.filterwarnings("error", message="string or file could not be read")
            yield
    finally:
        logger.setLevel(before)


def _joined(data: bytes, path: Path) -> TriangleMesh:
    """All meshes of a file that trimesh reads, as they are in it: nothing merged or removed."""
    scene = trimesh.load_scene(
        io.BytesIO(data),
        path.suffix.lower()[1:],
        FilePathResolver(str(path)),
        process=False,
        maintain_order=True,
        skip_materials=True,
    )
    dumped = scene.dump()
    shapes = [s for s in dumped if isinstance(s, trimesh.Trimesh) and not s.is_empty]
    if not shapes:  # points alone, if anything
        clouds = [shape for shape in dumped if isinstance(shape, trimesh.PointCloud)]
        points = np.concatenate([np.zeros((0, 3)), *(cloud.vertices for cloud in clouds)])
        return TriangleMesh(points, np.zeros((0, 3), np.uint32))
    attributes = gltf.attributes(scene, shapes)
    visuals: list[Any] = [shape.visual for shape in shapes]
    if any(visual.kind == "vertex" for visual in visuals):
        colours = np.concatenate([visual.vertex_colors for visual in visuals])
        attributes["colours"] = colours[:, :3] / 255
    first = np.cumsum([0, *(len(shape.vertices) for shape in shapes[:-1])])
    faces = [s.faces.reshape(-1, 3) + n for s, n in zip(shapes, first, strict=True)]
    points = np.concatenate([shape.vertices for shape in shapes])
    return TriangleMesh(points, np.concatenate(faces), **attributes)


def _read_obj(data: bytes, path: Path) -> TriangleMesh:
    data = data.replace(b"\r", b"").replace(b"\\\n", b" ").replace(b"\t", b" ")
    if (rich := parse_obj(data)) is not None:
        return rich
    # one mesh whatever its objects and materials; and corners that are points alone, because trimesh cuts
    # the mesh where a point has several normals or uvs
    other = rb"#[^\n]*|^ *(?:[ogs]|usemtl|mtllib)\b[^\n]*|(?<=\d)/\S*|^ +"
    data = re.sub(other, b"", data, flags=re.MULTILINE)
    if data.strip() and not re.search(rb"^v ", data, re.MULTILINE):
        raise ValueError("expected points ('v' lines), got none: no mesh in it")
    if re.search(rb"^f[^\n]* [+-]?0+(?!\d)", data, re.MULTILINE):
        raise ValueError("faces: expected numbers from 1, got 0")
    # trimesh counts relative numbers from the last point of the file
    relative = re.search(rb"^f[^\n]* -", data, re.MULTILINE)
    if relative and data.rfind(b"\nv ") > relative.start():
        raise ValueError("faces: expected relative numbers after the last point, got them before")
    return _joined(data, path)


def _read_stl(data: bytes, path: Path) -> TriangleMesh:
    size = 84 + 50 * int.from_bytes(data[80:84], "little")
    if len(data) != size:
        text = data.lower()
        if not text.lstrip().startswith(b"solid"):
            raise ValueError(f"truncated or no STL: expected {size} bytes, got {len(data)}")
        if b"endsolid" not in text or text.count(b"vertex") != 3 * text.count(b"endfacet"):
            raise ValueError("truncated: expected whole facets and 'endsolid'")
    return welded(_joined(data, path))


def _read_off(data: bytes, path: Path) -> TriangleMesh:
    data = re.sub(rb"#[^\n]*", b"", data)
    match = re.match(rb"\s*(?:ST)?C?N?OFF\s+(\d+)\s+(\d+)[^\n]*", data)
    if match is None:
        raise ValueError("expected 'OFF' and the counts of vertices and faces, got neither")
    count = int(match[1]) + int(match[2])
    rows = [row for row in data[match.end() :].splitlines() if row.strip()]
    last = rows[count - 1].split() if 0 < count <= len(rows) else []
    if len(rows) < count or (int(match[2]) and len(last) <= int(last[0])):
        raise ValueError(f"truncated: expected {count} whole vertices and faces, got fewer")
    return _joined(data, path)


def _read_glb(data: bytes, path: Path) -> TriangleMesh:
    size = int.from_bytes(data[8:12], "little")
    if data[:4] != b"glTF":
        raise ValueError("expected a GLB file, got no 'glTF' at its start")
    if size > len(data):
        raise ValueError(f"truncated: expected {size} bytes, got {len(data)}")
    return _joined(gltf.marked(data), path)


_READERS: dict[str, Callable[[bytes, Path], TriangleMesh]] = {
    ".ply": lambda data, path: parse_ply(data),
    ".obj": _read_obj,
    ".stl": _read_stl,
    ".off": _read_off,
    ".gltf": lambda data, path: _joined(gltf.marked(data), path),
    ".glb": _read_glb,
}
