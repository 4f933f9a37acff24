"""Mesh files in and out: PLY, OBJ, STL, OFF, glTF and GLB, told apart by their suffix.

Reading ends in a valid TriangleMesh or in one FileError of one line. Writing is atomic: the file appears
complete under its name, or what was there before stays.
"""

from __future__ import annotations

import contextlib
import logging
import os
import re
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import trimesh

from lodbench.datasets_gen.gltf import glb_parts, gltf_parts, parse_gltf, read_scene
from lodbench.datasets_gen.obj import obj_parts, parse_obj
from lodbench.datasets_gen.order import welded
from lodbench.datasets_gen.ply import fans, numbers_in, parse_ply, ply_parts
from lodbench.datasets_gen.surfaces import TriangleMesh

SUFFIXES = (".ply", ".obj", ".stl", ".off", ".gltf", ".glb")
_STL_TRIANGLE = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("extra", "<u2")])


class FileError(ValueError):
    """A file that cannot be read or written; the text is one line that says which and why."""


def read_mesh(path: str | os.PathLike[str]) -> TriangleMesh:
    """The mesh in a file of one of `SUFFIXES`.

    Points keep their order and stay unless the format has none to share: STL corners with equal coordinates
    become one point. The meshes of a glTF scene are moved to their places and joined; polygons are split
    into fans. Normals, uvs and colours come along where the file has them for every point.

    Raises:
        FileError: no such file, a folder, an unknown suffix, a truncated or broken file, no mesh in it,
            NaN or infinity, an index out of range. No triangles is no error.
    """
    path = Path(path)
    read = _checked_suffix(path, _READERS)
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise FileError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise FileError(f"{path}: expected a file, got a folder") from None
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror}") from None
    if not data:
        raise FileError(f"{path}: the file is empty (0 bytes)")
    try:
        with _quiet():
            return read(path, data)
    except MemoryError:
        raise
    except Exception as error:  # third-party readers raise whatever they like on a broken file
        text = " ".join(str(error).split()) or type(error).__name__
        if not isinstance(error, (ValueError, TypeError)):
            text = f"not a readable {path.suffix.lower()} file: {text}"
        raise FileError(f"{path}: {text[:300]}") from error


def write_mesh(path: str | os.PathLike[str], mesh: TriangleMesh) -> None:
    """Write `mesh` in the format of the suffix, atomically.

    PLY carries everything; OBJ positions, normals, uvs and colours; glTF and GLB the same, colours only
    without uvs; OFF positions; STL triangles alone. Colours are rounded to 8 bits except in OBJ.
    glTF, GLB and STL cannot hold points without triangles: these are left out.

    Raises:
        FileError: the path cannot be written, or the disk is full.
    """
    path = Path(path)
    check_writable(path)
    with _quiet():
        parts = _WRITERS[path.suffix.lower()](mesh)
    with replacing(path) as stream:
        for part in parts:
            stream.write(part)


def check_writable(path: str | os.PathLike[str]) -> None:
    """Raise FileError where `write_mesh(path, ...)` could not work: call it before long work."""
    path = Path(path)
    _checked_suffix(path, _WRITERS)
    check_replaceable(path)


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
        trial = _beside(path.resolve())
        trial.touch(exist_ok=False)
        trial.unlink()
    except OSError as error:
        raise FileError(f"{path}: cannot be written: {error.strerror}") from None


@contextlib.contextmanager
def replacing(path: Path):
    """A binary stream to a file beside `path`, which takes its name when all went well.

    On any failure the new file is removed and the old one is untouched.
    """
    target = path.resolve()  # through a symbolic link, which stays one
    fresh = _beside(target)
    try:
        with fresh.open("xb") as stream:
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        if target.exists():
            fresh.chmod(target.stat().st_mode & 0o777)
        fresh.replace(target)
    except OSError as error:
        raise FileError(f"{path}: cannot be written: {error.strerror or error}") from error
    finally:
        fresh.unlink(missing_ok=True)


def _beside(target: Path) -> Path:
    return target.with_name(f".{target.name[:100]}.{os.getpid()}.part")


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
    before = logger.disabled
    logger.disabled = True
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            # text that stops being numbers midway
            warnings.filterwarnings("error", message="string or file could not be read")
            yield
    finally:
        logger.disabled = before


def _read_stl(path: Path, data: bytes) -> TriangleMesh:
    if len(data) >= 84 and len(data) == 84 + 50 * int.from_bytes(data[80:84], "little"):
        corners = np.frombuffer(data, _STL_TRIANGLE, offset=84)["corners"].reshape(-1, 3)
    else:
        text = data.lower()
        if not text.lstrip().startswith(b"solid"):
            count = int.from_bytes(data[80:84], "little")
            raise ValueError(f"truncated or no STL: {count} triangles need {84 + 50 * count} bytes,"
                             f" got {len(data)}")  # fmt: skip
        if b"endsolid" not in text or text.count(b"vertex") != 3 * text.count(b"endfacet"):
            raise ValueError("truncated: expected whole facets and 'endsolid'")
        scene = read_scene(path)
        parts = [g.vertices for g in scene.geometry.values() if isinstance(g, trimesh.Trimesh)]
        corners = np.concatenate([np.zeros((0, 3)), *parts])
        if len(corners) != 3 * text.count(b"endfacet"):
            raise ValueError("expected facets of three vertices, got something else")
    # a check before the weld, which compares numbers
    soup = TriangleMesh(corners, np.arange(len(corners)).reshape(-1, 3))
    return welded(soup)


def _read_off(path: Path, data: bytes) -> TriangleMesh:
    data = re.sub(rb"#[^\n]*", b"", data) if b"#" in data else data
    match = re.match(rb"\s*(?:ST)?C?N?OFF\b(?: *BINARY)?\s*(\d+)\s+(\d+)[^\n]*\n?", data)
    if match is None:
        raise ValueError("expected 'OFF' and the counts of vertices and faces, got neither")
    vertices, faces = int(match[1]), int(match[2])
    body = data[match.end() :]
    numbers = numbers_in(body) if b"C" not in match[0] else np.zeros(0)
    if len(numbers) == 3 * vertices + 4 * faces and (numbers[3 * vertices :: 4] == 3).all():
        corners = numbers[3 * vertices :].reshape(faces, 4)[:, 1:].astype(np.int64)
        return TriangleMesh(numbers[: 3 * vertices].reshape(vertices, 3), corners)
    # line by line: polygons, or more columns than are wanted here
    rows = [row for line in body.splitlines() if (row := line.split())]
    if len(rows) < vertices + faces:
        raise ValueError(
            f"truncated: expected {vertices} vertices and {faces} faces, got {len(rows)} lines"
        )
    positions = np.array([row[:3] for row in rows[:vertices]], np.float64).reshape(vertices, 3)
    rows = rows[vertices : vertices + faces]
    lengths = np.array([int(row[0]) for row in rows], np.int64)
    corners = [row[1 : 1 + n] for row, n in zip(rows, lengths, strict=True)]
    if any(len(row) != n for row, n in zip(corners, lengths, strict=True)):
        raise ValueError(
            "truncated: expected as many indices in each face as its first number says"
        )
    indices = np.array([int(index) for row in corners for index in row], np.int64)
    return TriangleMesh(positions, fans(lengths, indices))


def _stl_parts(mesh: TriangleMesh) -> list[bytes]:
    rows = np.zeros(mesh.triangle_count, _STL_TRIANGLE)
    rows["corners"] = mesh.positions[mesh.triangles]
    a, b, c = rows["corners"].astype(np.float64).transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    rows["normal"] = normals / np.where(length > 0, length, 1)
    header = b"triangle mesh".ljust(80) + mesh.triangle_count.to_bytes(4, "little")
    return [header, rows.tobytes()]


def _off_parts(mesh: TriangleMesh) -> list[bytes]:
    points = ("%.9g %.9g %.9g\n" * mesh.vertex_count) % tuple(mesh.positions.ravel().tolist())
    faces = ("3 %d %d %d\n" * mesh.triangle_count) % tuple(mesh.triangles.ravel().tolist())
    return [f"OFF\n{mesh.vertex_count} {mesh.triangle_count} 0\n{points}{faces}".encode()]


_READERS: dict[str, Callable[[Path, bytes], TriangleMesh]] = {
    ".ply": lambda path, data: parse_ply(data),
    ".obj": lambda path, data: parse_obj(data),
    ".stl": _read_stl,
    ".off": _read_off,
    ".gltf": parse_gltf,
    ".glb": parse_gltf,
}
_WRITERS: dict[str, Callable[[TriangleMesh], list[bytes]]] = {
    ".ply": ply_parts,
    ".obj": obj_parts,
    ".stl": _stl_parts,
    ".off": _off_parts,
    ".gltf": gltf_parts,
    ".glb": glb_parts,
}
