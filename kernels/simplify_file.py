"""simplify_file: from a mesh file to a mesh file, in batches where the mesh would not fit into the memory allowed."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from lodbench.datasets_gen.ply import ply_faces, ply_head, ply_vertices, vertex_columns
from lodbench.kernels import verbs
from lodbench.kernels.api import open_device, simplify_mesh
from lodbench.kernels.opencl import Device, Unsupported
from lodbench.kernels.parameters import check, shown
from lodbench.kernels.result import Left, Told
from lodbench.kernels.targets import given_targets

MINIMUM = 64 << 20
"""Bytes below which `memory` is refused: a batch, a window of the file and a small grid."""

_UNITS = {"": 1, "k": 1 << 10, "m": 1 << 20, "g": 1 << 30, "t": 1 << 40}
# bytes in core, about: parsing widens a file's faces, and the device has the mesh and its result
_PER_TRIANGLE, _PER_VERTEX = 160, 80
_ROW_BYTES = (
    512  # of a triangle while its batch is at work, host and device, the next batch among them
)
_DEVICE_SHARE = (
    5 / 8
)  # of the memory for the device's buffers; its pool holds a quarter of that more
_WINDOW_SHARE = 1 / 8


@dataclass(frozen=True)
class Written:
    """What was written.

    Attributes:
        path: the output.
        vertices_in, triangles_in: of the input; STL out of core has three points for each triangle.
        vertices, triangles: of the output.
        streamed: was it done in batches?
        extras: what the input has and the output has not, by name.
        counters: those of the method; in core some are made, of the mesh, when they are first asked for.
    """

    path: Path
    vertices_in: int
    triangles_in: int
    vertices: int
    triangles: int
    streamed: bool
    extras: tuple[str, ...] = ()
    counters: Mapping[str, int | float] = field(default_factory=dict)


def memory_bytes(memory: int | str) -> int:
    """Bytes of `512M`, `2G`, `1.5GiB` (powers of 1024) or a number.

    Raises:
        TypeError, ValueError: none of these, or less than `MINIMUM`.
    """
    memory = check("memory", memory, int | str)
    found = re.fullmatch(r"\s*(\d+(?:\.\d*)?|\.\d+)\s*([kmgt]?)(?:i?b)?\s*", str(memory), re.I)
    if found is None:
        raise ValueError(f"memory: expected bytes such as 512M or 2G, got {shown(memory)}")
    count = int(float(found[1]) * _UNITS[found[2].lower()])
    if count < MINIMUM:
        raise ValueError(f"memory: expected at least {MINIMUM >> 20}M, got {shown(memory)}")
    return count


def limited_device(memory: int | str, device: Device | str | None = None) -> Device:
    """A device whose buffers keep to their share of `memory`: one of its own on an open device's hardware."""
    limit = int(_DEVICE_SHARE * memory_bytes(memory))
    if isinstance(device, Device):
        return Device(device.handle, memory_limit=limit, one_core=device.facts.one_core)
    return Device.open(device, memory_limit=limit)


def simplify_file(
    source: str | os.PathLike[str],
    out: str | os.PathLike[str],
    *,
    target_reduction: float | None = None,
    target_count: int | None = None,
    cells: int | float | tuple[int, int, int] | None = None,
    memory: int | str | None = None,
    method: str | None = None,
    device: Device | str | None = None,
    told: Told | None = None,
    **options: Any,
) -> Written:
    """Fewer triangles of the same shape, from a file to a file.

    Where the mesh would not fit into `memory`, its triangles are streamed in batches through the same passes; the
    points and triangles are then those that are made in core, byte for byte. Out of core go binary PLY (triangles
    alone, x y z as float or double) and binary STL, to PLY, by quadric_clustering and vertex_average without
    remove_duplicates and warps. Points of STL need not be merged for the former: a cell's sums are over corners. The
    latter, and border="keep", take PLY alone.

    Normals and colours become means over cells, which are not parted at seams as they are in core; texture coordinates,
    of which that would make nonsense, stay behind, and with attributes=False all of them do.

    The output takes its name when it is whole, whatever happens before that; the temporary file beside it, of 12 bytes
    a triangle left, has no name.

    Args:
        source: the mesh file.
        out: the file to write.
        target_reduction: see `simplify_mesh`, as `target_count` and `cells`; a target is searched for over the file.
        target_count: triangles left at most.
        cells: the grid.
        memory: bytes that the process may use beyond what it has now, such as "2G"; None works in core.
        method: a system's name; None: as `simplify_mesh`, but where `memory` is given quadric_clustering.
        device: an open device, whose own limit counts then (see `limited_device`), a name, or None for the default.
        told: called with what is being done and the share that is done, 0 to 1, out of core.
        **options: the method's own.

    Raises:
        TypeError, ValueError: an argument or the file is wrong; FileError where one cannot be read or written; too
            little memory for the grid.
        Unsupported: the device cannot hold the mesh.
    """
    from lodbench.datasets_gen import contents, formats, read  # trimesh takes half a second

    source, out = Path(source), Path(out)
    targets = {"target_reduction": target_reduction, "target_count": target_count, "cells": cells}
    given_targets(targets | options)
    read.check_writable(out)
    if memory is not None:
        allowed = memory_bytes(memory)
        if method is None:  # the same whether it fits or not
            method = verbs.streaming_method()
        if not fits(source, allowed):
            return _streamed(source, out, allowed, method, device, told, targets | options)
    data = read.file_bytes(source)
    mesh = read.parse_mesh(data, source)
    extras = tuple(contents.extras(data, source))
    del data
    result = simplify_mesh(open_device(device), mesh, method=method, **targets, **options)
    read.write_mesh(out, result.mesh)
    carried = formats.CARRIED.get(out.suffix.lower(), ())
    kept = {name for name in carried if getattr(result.mesh, name) is not None}
    extras = tuple(name for name in extras if name not in kept)
    return Written(
        out, mesh.vertex_count, mesh.triangle_count, result.mesh.vertex_count,
        result.mesh.triangle_count, False, extras, result.counters,
    )  # fmt: skip


def fits(source: Path, allowed: int) -> bool:
    """Would the mesh of a file fit into so many bytes in core? Told from its header, and from its size elsewhere."""
    from lodbench.datasets_gen import batches, read

    if not source.is_file():
        return True  # reading it says what is wrong
    size = source.stat().st_size
    try:
        found = batches.MeshFile(source)
        need = _PER_TRIANGLE * found.triangle_count + _PER_VERTEX * found.vertex_count
    except read.FileError:
        need = 8 * size
        if need > allowed:
            raise
    return size + need <= allowed


def _streamed(
    source: Path,
    out: Path,
    allowed: int,
    method: str | None,
    device: Device | str | None,
    told: Told | None,
    options: dict[str, Any],
) -> Written:
    from lodbench.datasets_gen import batches, read

    simplify_batches = verbs.streaming(method)
    if out.suffix.lower() != ".ply":
        raise ValueError(f"{out}: expected a name that ends in .ply out of core, got {out.suffix}")
    told = told or (lambda what, share: None)
    opened = device if isinstance(device, Device) else limited_device(allowed, device)
    file = batches.MeshFile(source, int(_WINDOW_SHARE * allowed))
    rows = max(1 << 13, min(1 << 19, allowed // 4 // _ROW_BYTES))
    try:
        with tempfile.TemporaryFile(dir=out.resolve().parent) as spill:
            left = simplify_batches(opened, file, spill, rows, told, **options)
            with read.replacing(out) as stream:
                _write(left, spill, stream, rows, told)
    except Unsupported as error:
        if "bytes of device memory" not in str(error):
            raise
        raise ValueError(
            f"memory: expected enough for the grid's cells, got {allowed >> 20}M: {error}"
        ) from None
    except OSError as error:
        raise read.FileError(f"{out}: cannot be written: {error.strerror or error}") from error
    return Written(
        out, file.vertex_count, file.triangle_count, len(left.vertices), left.triangle_count, True,
        tuple(name for name in file.extras if name not in left.attributes), left.counters,
    )  # fmt: skip


def _write(left: Left, spill: BinaryIO, out: BinaryIO, rows: int, told: Told) -> None:
    """The PLY file that `ply.ply_file` makes of the mesh, written piece by piece."""
    from lodbench.datasets_gen.batches import pieces

    for start, stop in [*pieces(len(left.vertices), rows)] or [(0, 0)]:
        points = left.vertices[start:stop]
        own = {name: values[start:stop] for name, values in left.attributes.items()}
        columns = vertex_columns(points if left.origin is None else points + left.origin, **own)
        if not start:
            kinds = {name: values.dtype for name, values in columns.items()}
            out.write(ply_head(kinds, len(left.vertices), left.triangle_count))
        out.write(ply_vertices(columns))
    spill.seek(0)
    for start, stop in pieces(left.triangle_count, rows):
        numbers = np.frombuffer(spill.read(12 * (stop - start)), np.uint32).reshape(-1, 3)
        out.write(ply_faces(left.numbers[numbers]))
        told("write", 1 - 0.05 * (1 - stop / left.triangle_count))
