"""One call of `lodbench.kernels.simplify_file`, from a file to a file: in core, or streamed within so much memory.

The file is made of copies of the dataset side by side, written to a temporary folder: as large as wanted.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from lodbench.datasets_gen import read
from lodbench.datasets_gen.ply import ply_faces, ply_head
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.kernels.cluster.target import GridTarget
from lodbench.kernels.opencl import Device
from lodbench.kernels.parameters import Range
from lodbench.kernels.simplify_file import limited_device, memory_bytes, simplify_file
from lodbench.kernels.system import Check, Timeline

_GAP = 1.1  # from copy to copy, box edges


@dataclass(frozen=True)
class Params(GridTarget):
    """How far and within what memory; a search for the grid is part of the call.

    Attributes:
        memory: see `simplify_file`; None works in core.
        copies: of the dataset, side by side in the file.
        measured: count the peak of a process that makes the same call, and whether the bytes are those in core.
        compared: make the file in core too, for what says that they are the same.
    """

    memory: str | None = None
    copies: Annotated[int, Range(1)] = 1
    measured: bool = False
    compared: bool = True


def write_copies(path: Path, mesh: TriangleMesh, copies: int) -> None:
    """A PLY file of copies of a mesh in a cubic lattice, written copy by copy."""
    side = math.ceil(round(copies ** (1 / 3), 6))
    step = np.float32(_GAP) * (mesh.box[1] - mesh.box[0]).astype(np.float32)
    places = np.stack(np.unravel_index(np.arange(copies), (side, side, side)), axis=1)
    with path.open("wb") as stream:
        kinds = dict.fromkeys("xyz", np.dtype(np.float32))
        head = ply_head(kinds, copies * mesh.vertex_count, copies * mesh.triangle_count)
        stream.write(head)
        for place in places.astype(np.float32):
            stream.write((mesh.positions + place * step).astype("<f4").data)
        for copy in range(copies):
            stream.write(ply_faces(mesh.triangles + np.uint32(copy * mesh.vertex_count)))


def prepare(device: Device, mesh: TriangleMesh, params: Params) -> HostPrepared:
    """The file written, and a small one simplified already, so that timed calls find everything compiled."""
    folder = tempfile.TemporaryDirectory(prefix="lodbench-")  # gone with the subject
    source, out, whole = (Path(folder.name) / f"{name}.ply" for name in ("in", "out", "whole"))
    cells = params.cells
    if params.target_reduction is None and params.target_count is None:
        cells = params.grid_cells
    asked = {"target_reduction": params.target_reduction, "target_count": params.target_count}
    asked |= {"cells": cells, "method": "quadric_clustering"}  # what files are streamed by
    setup = Timeline()
    with setup.host("file"):
        write_copies(source, mesh, params.copies)
    own = device if params.memory is None else limited_device(params.memory, device)
    with setup.host("first_launch"):
        write_copies(out, mesh, 1)
        simplify_file(out, out, device=own, cells=4)

    def call(_: Any) -> Path:
        assert folder.name  # and with it the files, as long as this is called
        simplify_file(source, out, device=own, memory=params.memory, **asked)
        return out

    @cache
    def expected() -> bytes:
        simplify_file(source, whole, device=device, **asked)
        return whole.read_bytes()

    @cache
    def peak() -> int:
        return peak_bytes(source, whole, params.memory, asked)

    def verdict(meshes: Sequence[TriangleMesh]) -> Check:
        if not params.compared:
            return Check(True, "triangles, since nothing was made in core", 0, 0)
        differ = int(out.read_bytes() != expected())
        return Check(not differ, "files unlike the one made in core", differ, 0)

    def count(_: Any) -> Mapping[str, int | float]:
        found = {
            "triangles_read": params.copies * mesh.triangle_count,
            "file_bytes": source.stat().st_size,
        }
        if params.memory is not None:
            found["memory_limit_bytes"] = memory_bytes(params.memory)
        if params.measured:
            found["peak_bytes"] = peak()
            if params.compared:
                found["same_bytes"] = int(out.read_bytes() == expected())
        return found

    return HostPrepared(
        device,
        call,
        read=lambda path: [read.read_mesh(path)],
        verdict=verdict,
        setup=setup,
        input_bytes=source.stat().st_size,
        count=count,
    )


def peak_bytes(source: Path, out: Path, memory: str | None, asked: Mapping[str, Any]) -> int:
    """By how much the call raises the peak of a process that has simplified a small file before; Linux and macOS."""
    told = json.dumps({"source": str(source), "out": str(out), "memory": memory, "asked": asked})
    command = [sys.executable, "-m", f"{__name__}.peak", told]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return int(done.stdout)


SYSTEM = host_system(
    "simplify_file",
    "lodbench.kernels.simplify_file",
    prepare,
    {"cells_64": Params(64), "within_64M": Params(30, memory="64M", copies=8)},
    notes="wall time from a file to a file",
)
