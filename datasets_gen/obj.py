"""OBJ files: points, faces, normals and texture coordinates; materials and groups are passed over."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.ply import fans, numbers_in
from lodbench.datasets_gen.surfaces import TriangleMesh

_PASSED_OVER = set(
    b"o g s l p mg vp usemtl mtllib usemap maplib shadow_obj trace_obj lod bevel c_interp d_interp"
    b" cstype deg curv curv2 surf parm trim hole scrv sp end con bmat step ctech stech call csh".split()
)
_SPACE, _NEWLINE, _SLASH = 32, 10, 47
_KEYS = (b"v", b"vt", b"vn", b"f")


class _Statements:
    """An OBJ text cut into statements, all at once: where each word starts, and what each line says."""

    def __init__(self, data: bytes) -> None:
        data = data.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ")
        if b"#" in data:
            data = re.sub(rb"#[^\n]*", b"", data)
        # two spaces more, so that looking one or two bytes ahead stays inside
        self.text = np.frombuffer(data + b"  ", np.uint8).copy()
        blank = self.text <= _SPACE
        starts = ~blank
        starts[1:] &= blank[:-1]
        self.words = np.flatnonzero(starts)
        lines = np.searchsorted(np.flatnonzero(self.text == _NEWLINE), self.words)
        first = np.ones(len(lines), bool)
        first[1:] = lines[1:] != lines[:-1]
        self.keys = np.flatnonzero(first)  # the first word of each line that has any
        at = self.words[self.keys]
        self.kind = np.full(len(at), -1, np.int8)
        for kind, key in enumerate(_KEYS):
            same = blank[at + len(key)]
            for i, letter in enumerate(key):
                same &= self.text[at + i] == letter
            self.kind[same] = kind
        self.counts = np.diff(np.append(self.keys, len(self.words))) - 1
        ends = np.append(at[1:], len(self.text))[: len(at)]
        unknown = np.flatnonzero(self.kind < 0)
        self.unknown = next(
            (w for k in unknown[:1000] if (w := self._word(at[k])) not in _PASSED_OVER), b""
        )
        for letter in range(2):  # the keys are blanked, so that only numbers remain
            self.text[at[self.kind >= 0] + letter * (self.kind[self.kind >= 0] % 3 > 0)] = _SPACE
        self.kind_of_byte = np.full(len(self.text), -1, np.int8)
        if len(at):
            self.kind_of_byte[at[0] :] = np.repeat(self.kind, ends - at)

    def _word(self, start) -> bytes:
        return self.text[start : start + 40].tobytes().split()[0]

    def count(self, key: bytes) -> int:
        return int((self.kind == _KEYS.index(key)).sum())

    def rows(self, key: bytes, least: int) -> NDArray[np.float64]:
        """The numbers of all lines of a key, (lines, columns); longer lines are cut to the shortest."""
        kind = _KEYS.index(key)
        widths = self.counts[self.kind == kind]
        if not len(widths):
            return np.zeros((0, 3))
        name = key.decode()
        if widths.min() < least:
            raise ValueError(f"expected {least} numbers after {name!r}, got {widths.min()}")
        try:
            values = numbers_in(self.text[self.kind_of_byte == kind].tobytes())
        except ValueError:
            values = np.zeros(0)
        if len(values) != widths.sum():
            raise ValueError(f"expected numbers after {name!r}, got something else")
        starts = np.cumsum(widths) - widths
        return values[starts[:, None] + np.arange(widths.min())]

    def corners(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Corners per face, (n,), and point, uv and normal number of each corner, (sum, 3), 0 = none."""
        kind = _KEYS.index(b"f")
        faces = self.kind == kind
        lengths = self.counts[faces]
        text = self.text[self.kind_of_byte == kind]
        slash = text == _SLASH
        gap = slash | (text <= _SPACE)
        starts = ~gap
        starts[1:] &= gap[:-1]
        numbers = np.flatnonzero(starts)
        starts = text > _SPACE
        starts[1:] &= text[:-1] <= _SPACE
        words = np.flatnonzero(starts)
        # which word a number is in, and how many slashes of that word stand before it
        word = np.searchsorted(words, numbers, "right") - 1
        slashes = np.flatnonzero(slash)
        column = np.searchsorted(slashes, numbers) - np.searchsorted(slashes, words)[word]
        text[slash] = _SPACE
        values = numbers_in(text.tobytes(), np.int64)
        if len(values) != len(numbers) or (column > 2).any():
            raise ValueError("expected corners like 1, 1/2, 1//3 or 1/2/3 after 'f', got others")
        result = np.zeros((len(words), 3), np.int64)
        result[word, column] = values
        if (result < 0).any():
            # -1 is the last one before this line
            seen = [np.cumsum(self.kind == k)[faces] for k in range(3)]
            before = np.repeat(np.stack(seen, axis=1), lengths, axis=0)
            counted = result + before + 1
            result = np.where(result < 0, np.where(counted > 0, counted, -1), result)
        return lengths, result


def _vertices_of(
    corners: NDArray[np.int64], points: int, kinds: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """One vertex per (point, uv) pair: index of each corner's vertex, point and uv of each vertex.

    The first uv of a point keeps the point's own number; further ones go to the end.
    """
    pairs, inverse = np.unique(corners[:, 0] * kinds + corners[:, 1], return_inverse=True)
    point, uv = np.divmod(pairs, kinds)
    again = np.concatenate([np.zeros(1, bool), point[1:] == point[:-1]])
    number = np.where(again, points + np.cumsum(again) - 1, point)
    point_of = np.concatenate([np.arange(points), point[again]])
    uv_of = np.full(len(point_of), -1)
    uv_of[number] = uv
    return number[inverse.reshape(-1)], point_of, uv_of


def parse_obj(data: bytes) -> TriangleMesh:
    """The mesh in an OBJ file: all its objects and groups in file order, polygons split into fans.

    Points keep their order, used or not. A point with several texture coordinates becomes several vertices;
    one with several normals gets their mean, so that hard edges do not cut the mesh.

    Raises:
        ValueError: no OBJ statement in it, a bad number, or an index out of range (0 included).
    """
    statements = _Statements(data)
    if statements.unknown and not statements.count(b"v"):
        got = statements.unknown.decode("latin-1")
        raise ValueError(f"expected OBJ statements, got {got!r}: no mesh in it")
    points = statements.rows(b"v", 3)
    colours = points[:, 3:6] if points.shape[1] >= 6 else None
    uvs, normals = statements.rows(b"vt", 1), statements.rows(b"vn", 3)
    lengths, corners = statements.corners()
    counts = np.array([len(points), len(uvs), len(normals)])
    outside = ((corners < (1, 0, 0)) | (corners > counts)).any(axis=1)
    if outside.any():
        got = corners[int(np.argmax(outside))].tolist()
        raise ValueError(f"faces: expected numbers up to {counts.tolist()}, got {got} (v, vt, vn)")
    corners -= 1

    vertex, point_of = corners[:, 0], np.arange(len(points))
    vertex_uvs = vertex_normals = None
    if len(corners) and (corners[:, 1] >= 0).all() and uvs.shape[1] >= 2:
        vertex, point_of, uv_of = _vertices_of(corners, len(points), len(uvs))
        vertex_uvs = np.where(uv_of[:, None] >= 0, uvs[uv_of, :2], 0.0)
    if len(corners) and (corners[:, 2] >= 0).all() and normals.shape[1] == 3:
        given = normals[corners[:, 2]]
        total = np.stack([np.bincount(vertex, g, len(point_of)) for g in given.T], axis=1)
        length = np.linalg.norm(total, axis=1, keepdims=True)
        vertex_normals = np.where(length > 0, total / np.where(length > 0, length, 1), (0, 0, 1))
    return TriangleMesh(
        points[point_of, :3],
        fans(lengths, vertex),
        vertex_normals,
        vertex_uvs,
        None if colours is None else colours[point_of],
    )


def _lines(start: str, values: NDArray, form: str) -> str:
    line = start + " " + " ".join([form] * values.shape[1]) + "\n"
    return (line * len(values)) % tuple(values.ravel().tolist())


def obj_parts(mesh: TriangleMesh) -> list[bytes]:
    """An OBJ file of `mesh`, in parts; nine digits keep every float32 exactly."""
    points = mesh.positions
    if mesh.colours is not None:
        points = np.concatenate([points, mesh.colours], axis=1)
    parts = ["# triangle mesh\n", _lines("v", points, "%.9g")]
    form = "%d"
    if mesh.uvs is not None:
        parts.append(_lines("vt", mesh.uvs, "%.9g"))
        form = "%d/%d"
    if mesh.normals is not None:
        parts.append(_lines("vn", mesh.normals, "%.9g"))
        form += "/%d" if mesh.uvs is not None else "//%d"
    corners = np.repeat(mesh.triangles.astype(np.int64) + 1, form.count("%"), axis=1)
    line = "f " + " ".join([form] * 3) + "\n"
    parts.append((line * mesh.triangle_count) % tuple(corners.ravel().tolist()))
    return [part.encode() for part in parts]
