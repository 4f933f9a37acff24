"""Triangles of a file that need not fit into memory, in batches: binary PLY of either byte order, and binary STL.

Faces are read in order. The corners of a batch lie anywhere among the vertices: those whose vertices stand together are
read as one piece, others are gathered from the mapped file, window by window in the order of the file, so that no more
of it is resident than a window. Files whose order follows their surface have the former, scattered ones read at random.

long because two formats are checked before anything is read, and both ways of reading corners belong to one file.
"""

from __future__ import annotations

import mmap
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen import contents, ply, read
from lodbench.datasets_gen.arrays import Origin, box, middle

AVERAGED = ("normals", "colours")
SUFFIXES = (".ply", ".stl")
VERTICES = 1 << 18  # of a piece that is read for itself: 3 to 6 MB
_CLUSTER = 16  # pages that one fault maps, where they are in the system's cache
_STL = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
T = TypeVar("T")


class Batch(NamedTuple):
    """`positions` (k, 3) float32 from the file's origin; `triangles` (m, 3) uint32, rows of them.

    `vertices` are the rows of the file that the positions stand in where triangles share them: (k,), or the first of
    k in a row. `values` has what was asked for of the points, (k, 3) each by name.
    """

    positions: NDArray[np.float32]
    triangles: NDArray[np.uint32]
    vertices: NDArray[np.integer] | int = 0
    values: Mapping[str, NDArray[np.float32]] = MappingProxyType({})


class _State(NamedTuple):
    """By which one notices that a file is another."""

    number: int
    size: int
    changed_ns: int


class _Rows:
    """Rows of one layout at a place in a file, which is still the same after each reading."""

    def __init__(self, path: Path, state: _State, layout: np.dtype, count: int, at: int) -> None:
        self._path, self._state = path, state
        self.layout, self.count, self.at = layout, count, at

    @property
    def end(self) -> int:
        return self.at + self.count * self.layout.itemsize

    def read(self, start: int, stop: int) -> NDArray:
        """Rows start .. stop - 1.

        Raises:
            FileError: the file changed, or cannot be read any more.
        """
        offset = self.at + start * self.layout.itemsize
        try:
            found = np.fromfile(self._path, self.layout, stop - start, offset=offset)
        except OSError as error:
            raise read.FileError(f"{self._path}: cannot be read: {error.strerror}") from None
        _check_same(self._path, self._state)
        if len(found) < stop - start:
            raise read.FileError(f"{self._path}: truncated while it was read")
        return found


class MeshFile:
    """A mesh file, opened and its size checked; nothing of its body is read before it is asked for.

    Attributes:
        path: the file.
        vertex_count: points; three for each triangle where the format has none to share (STL).
        triangle_count: triangles.
        shared: may triangles share points?
        origin: where positions count from, see `TriangleMesh`; known once `box` is.
        extras: what the file has beside points and triangles, by name.
        attributes: those of them whose mean over several points says something of their points: normals, colours.
        carried: those of these that batches have.
    """

    def __init__(self, path: str | os.PathLike[str], window_bytes: int = 1 << 26) -> None:
        """Open it.

        Args:
            path: the file.
            window_bytes: of the mapped file that may be resident at once.

        Raises:
            FileError: no such file, another format, polygons, truncated.
        """
        self.path, self._window = Path(path), window_bytes
        self.origin: Origin | None = None
        self.attributes: tuple[str, ...] = ()
        self.carried: tuple[str, ...] = ()
        self._map: mmap.mmap | None = None
        self._state = _state(self.path)
        size = self._state.size
        with self.path.open("rb") as stream:
            start = stream.read(1 << 16)
        if contents.format_of(start) == ".ply":
            self._open_ply(start, size)
        elif size >= 84 and size == 84 + 50 * int.from_bytes(start[80:84], "little"):
            self._open_stl(start)
        else:
            raise self._refused("a whole binary file of PLY or STL", "another")
        self._kind = self._vertices.layout["x" if self.shared else "corners"].base

    def _refused(self, expected: str, got: object) -> read.FileError:
        return read.FileError(f"{self.path}: out of core: expected {expected}, got {got}")

    def _open_stl(self, start: bytes) -> None:
        self.shared, self.extras = False, ()
        self.triangle_count = int.from_bytes(start[80:84], "little")
        self.vertex_count = 3 * self.triangle_count
        self._vertices = self._faces = _Rows(self.path, self._state, _STL, self.triangle_count, 84)

    def _open_ply(self, start: bytes, size: int) -> None:
        try:
            encoding, elements, at = ply.header(start)
        except ValueError as error:
            raise read.FileError(f"{self.path}: {error}") from None
        if encoding == "ascii":
            raise self._refused("binary PLY", "text")
        tables: dict[str, _Rows] = {}
        for name, (count, properties) in elements.items():
            if {"vertex", "face"} <= tables.keys():
                break
            lists = [p.name for p in properties if p.length_kind]
            if len(lists) > (name == "face"):
                raise self._refused(f"no lists in the rows of {name!r}", ", ".join(lists))
            layout = ply.row_layout(properties, (3,) * len(lists))
            tables[name] = _Rows(self.path, self._state, layout, count, at)
            at = tables[name].end
            if name == "face":
                self._list = lists[0] if lists else ""
        if not {"vertex", "face"} <= tables.keys():
            raise self._refused("vertices and faces", ", ".join(tables) or "neither")
        self.extras = tuple(contents.extras(start, Path("a.ply")))
        self.attributes = tuple(name for name in AVERAGED if name in self.extras)
        self._vertices, self._faces = tables["vertex"], tables["face"]
        self.shared = True
        self.vertex_count, self.triangle_count = self._vertices.count, self._faces.count
        fields = self._vertices.layout.fields or {}
        kinds = [fields[name] for name in "xyz" if name in fields]
        step = kinds[0][0].itemsize if kinds else 0
        places = [fields["x"][1] + axis * step for axis in range(3)] if len(kinds) == 3 else []
        same = {kind[0] for kind in kinds}
        if len(same) != 1 or min(same).char not in "fd" or [k[1] for k in kinds] != places:
            raise self._refused("x, y, z of one kind, float or double, side by side", list(fields))
        if self._list not in ("vertex_indices", "vertex_index"):
            raise self._refused("faces with vertex_indices", self._list or "none")
        if self._faces.layout[self._list].base.kind not in "iu":
            raise self._refused("whole numbers as vertex_indices", "others")
        if at > size:
            # of polygons with more corners than three a file is longer, never shorter
            raise read.FileError(f"{self.path}: truncated: expected {at} bytes or more, got {size}")

    # vertices

    def _given(self, start: int, stop: int) -> NDArray[np.floating]:
        """Points as the file has them, (stop - start, 3), float32 or float64."""
        if not self.shared:
            rows = self._vertices.read(start // 3, -(-stop // 3))["corners"].reshape(-1, 3)
            return rows[start % 3 :][: stop - start].astype(np.float64)  # as a reader of STL has it
        return self._points_of(self._vertices.read(start, stop))

    def _local(self, given: NDArray[np.floating]) -> NDArray[np.float32]:
        if self.origin is not None:
            given = given.astype(np.float64) - self.origin
        with np.errstate(over="ignore"):
            return np.ascontiguousarray(given, np.float32)

    def box(
        self, told: Callable[[float], None] = lambda share: None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The box of all points from `origin`, which is set; (3,) each, zeros where there are none.

        Raises:
            ValueError: NaN or infinity, also after rounding to float32.
        """
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        for start, stop in pieces(self.vertex_count, VERTICES):
            given = self._given(start, stop)
            lower, upper = box(given)
            if not (np.isfinite(lower).all() and np.isfinite(upper).all()):  # NaN is handed on
                row = int(np.argmin(np.isfinite(given).all(axis=1)))
                raise ValueError(
                    f"points: expected finite float32 values, got {given[row].tolist()} in row {start + row}"
                )
            low, high = np.minimum(low, lower), np.maximum(high, upper)
            told(stop / self.vertex_count)
        if not self.vertex_count:
            return np.zeros(3), np.zeros(3)
        narrow = self.shared and self._kind.itemsize == 4
        self.origin = None if narrow else middle(low, high)
        corners = self._local(np.stack([low, high]))
        if not np.isfinite(corners).all():
            raise ValueError(f"points: expected finite float32 values, got {low} to {high}")
        return corners[0].astype(np.float64), corners[1].astype(np.float64)

    def positions(self) -> Iterator[NDArray[np.float32]]:
        """All points, in order, in pieces of (k, 3) float32 from the origin."""
        for start, stop in pieces(self.vertex_count, VERTICES):
            yield self._local(self._given(start, stop))

    # triangles

    def batches(self, start: int, stop: int, rows: int, stride: int = 1) -> Iterator[Batch]:
        """Triangles start .. stop - 1, every `stride`-th one of the file, in order, out of `rows` at a time.

        Raises:
            FileError: polygons.
            ValueError: an index out of range.
        """
        for first, last in pieces(stop - start, rows):
            first, last = start + first, start + last
            yield self.batch(first, last, slice(-first % stride, None, stride))

    def batch(self, start: int, stop: int, which: slice | NDArray[np.bool_]) -> Batch:
        """Those of the triangles start .. stop - 1 that `which` says; errors are those of `batches`."""
        if self.shared:
            return self._gathered(self._corners(start, stop)[which])
        found = self._faces.read(start, stop)["corners"][which]
        positions = self._local(found.reshape(-1, 3).astype(np.float64))
        numbers = np.arange(len(positions), dtype=np.uint32)
        return Batch(positions, numbers.reshape(-1, 3))

    def corners(self, start: int, stop: int) -> NDArray[np.uint32]:
        """The vertices of triangles start .. stop - 1 by their rows, (stop - start, 3); as `batches` otherwise."""
        if self.shared:
            return self._corners(start, stop)
        return np.arange(3 * start, 3 * stop, dtype=np.uint32).reshape(-1, 3)

    def at(self, rows: NDArray[np.integer]) -> NDArray[np.float32]:
        """The points of these vertices, (k, 3), wherever they stand: of a format with shared ones."""
        return self._local(self._scattered(rows))

    def _corners(self, start: int, stop: int) -> NDArray[np.uint32]:
        """Rows of vertices of the triangles, (stop - start, 3), checked."""
        table = self._faces.read(start, stop)
        lengths = table[f"{self._list}#"]
        if not (lengths == 3).all():
            row = int(np.argmax(lengths != 3))
            raise self._refused("triangles alone", f"{lengths[row]} corners in face {start + row}")
        given = table[self._list]
        corners = np.ascontiguousarray(given.astype(np.uint32))  # what is negative becomes large
        if len(corners) and int(corners.max()) >= self.vertex_count:
            low, high = int(given.min()), int(given.max())
            raise ValueError(
                f"faces: expected indices from 0 to {self.vertex_count - 1}, got {low if low < 0 else high}"
            )
        return corners

    def _gathered(self, corners: NDArray[np.uint32]) -> Batch:
        if not len(corners):
            return Batch(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint32))
        low, high = int(corners.min()), int(corners.max()) + 1
        if high - low <= corners.size:
            triangles, vertices = corners - np.uint32(low), low
            rows = self._vertices.read(low, high) if self.carried else None
        else:
            triangles = np.arange(corners.size, dtype=np.uint32).reshape(-1, 3)
            vertices = corners.ravel()
            rows = self._scattered(vertices, whole=True) if self.carried else None
        if rows is not None:
            values = {name: self._values(rows, name) for name in self.carried}
            return Batch(self._local(self._points_of(rows)), triangles, vertices, values)
        if isinstance(vertices, int):
            return Batch(self._local(self._given(low, high)), triangles, vertices)
        return Batch(self.at(vertices), triangles, vertices)

    def _points_of(self, rows: NDArray) -> NDArray[np.floating]:
        place = (rows.dtype.fields or {})["x"][1]
        return _points(rows.data, self._kind, len(rows), place, rows.dtype.itemsize)

    def _values(self, rows: NDArray, name: str) -> NDArray[np.float32]:
        """Of rows of points, (k, 3): normals of unit length, colours from 0 to 1.

        Raises:
            ValueError: NaN or infinity.
        """
        names = ply.ATTRIBUTES[name][0]
        found = np.stack([rows[n] for n in names], axis=1)
        if found.dtype.kind != "f":
            return (found / float(np.iinfo(rows[names[0]].dtype).max)).astype(np.float32)
        if not np.isfinite(found).all():
            raise ValueError(f"{name}: expected finite values, got NaN or infinity")
        return unit(found) if name == "normals" else found.astype(np.float32)

    def _scattered(self, rows: NDArray[np.integer], whole: bool = False) -> NDArray:
        """Points of rows in any order, (k, 3), or the rows `whole`, with at most a window of the file resident."""
        _check_same(
            self.path, self._state
        )  # past the end of a file that was cut short the process would end
        if self._map is None:
            with self.path.open("rb") as stream:
                self._map = mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ)
        table, step = self._vertices, self._vertices.layout.itemsize
        at = table.at + (table.layout.fields or {})["x"][1]
        every = _points(self._map, self._kind, table.count, at, step)
        if whole:
            every = np.ndarray(table.count, table.layout, self._map, table.at)
        page = mmap.PAGESIZE * _CLUSTER
        touched = np.zeros(table.count * step // page + 1, bool)
        touched[rows.astype(np.int64) * step // page] = True
        if np.count_nonzero(touched) * page <= self._window:
            found = every[rows]
        else:
            order = np.argsort(rows)
            ordered = rows[order]
            edges = np.arange(0, table.count, max(self._window // step, 1))
            found = np.empty((len(rows), *every.shape[1:]), every.dtype)
            for part in np.split(np.arange(len(rows)), np.searchsorted(ordered, edges[1:])):
                found[order[part]] = every[ordered[part]]
                self._drop()
        self._drop()
        return found

    def _drop(self) -> None:
        """Pages stay in the system's cache, and are no longer this process's."""
        if self._map is not None and hasattr(mmap, "MADV_DONTNEED"):
            self._map.madvise(mmap.MADV_DONTNEED)


def _state(path: Path) -> _State:
    if path.is_dir():
        raise read.FileError(f"{path}: expected a file, got a folder")
    try:
        found = path.stat()
    except FileNotFoundError:
        raise read.FileError(f"{path}: no such file") from None
    except OSError as error:
        raise read.FileError(f"{path}: cannot be read: {error.strerror}") from None
    return _State(found.st_ino, found.st_size, found.st_mtime_ns)


def _check_same(path: Path, state: _State) -> None:
    """Raise FileError where the file is no longer what it was."""
    if _state(path) != state:
        raise read.FileError(f"{path}: changed while it was read")


def _points(data: object, kind: np.dtype, count: int, at: int, step: int) -> NDArray[np.floating]:
    """Three numbers of a kind in each row of `step` bytes, (count, 3)."""
    return np.ndarray((count, 3), kind, data, at, (step, kind.itemsize))  # type: ignore[arg-type]


def unit(vectors: NDArray[np.floating]) -> NDArray[np.float32]:
    """Vectors (k, 3) of unit length; (0, 0, 1) for those of none."""
    wide = vectors.astype(np.float64)
    length = np.sqrt((wide * wide).sum(axis=1, keepdims=True))
    none = length[:, 0] <= 1e-12 * max(float(length.max(initial=0)), 1e-300)
    wide /= np.where(length > 0, length, 1)
    wide[none] = 0.0, 0.0, 1.0
    return wide.astype(np.float32)


def pieces(count: int, rows: int) -> Iterator[tuple[int, int]]:
    """`count` rows in pieces of at most `rows`: first and past-the-last row of each."""
    for start in range(0, count, rows):
        yield start, min(start + rows, count)


def ahead(values: Iterable[T]) -> Iterator[T]:
    """The same, the next one made in another thread while this one is in use."""
    iterator, end = iter(values), object()
    with ThreadPoolExecutor(1) as reader:
        coming = reader.submit(next, iterator, end)
        while (value := coming.result()) is not end:
            coming = reader.submit(next, iterator, end)
            yield value  # type: ignore[misc]
