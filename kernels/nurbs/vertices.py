"""The launch that writes every vertex of a model: row after row of its grids, or tile after tile."""

from __future__ import annotations

from typing import Any

import numpy as np

from lodbench.kernels.launching import LINE, group_size, kernel_defines
from lodbench.kernels.nurbs.grids import tiles_of
from lodbench.kernels.opencl import Launch

LONG_CHUNK, LONG_GROUP = 1024, 2
"""Vertices of a work-item on a CPU, and work-items of a group: a chunk begins by finding its surface and row, and a cut
run of vertices is two. Not where stores go past the caches, for which each work-item holds its whole chunk."""
TILE_COLUMNS = 1032
"""Most columns of a grid that has tiles, so that what a tile keeps of control rows, 216 bytes for each column, stays in
a core's second cache."""
TILE_VERTICES, TILES = 1024, 4
"""Fewest vertices of a tile, and tiles for each core: each begins with control rows of its own."""


def vertex_launch(subject: Any, output_bytes: int) -> Launch:
    """The step by which a `Tessellated` writes its vertices, so many bytes."""
    defines = subject.defines | kernel_defines(subject.device, output_bytes)
    plain = not any(defines[name] for name in ("NORMALS", "RATIONAL", "STREAMING"))
    narrow = all(grid.columns <= TILE_COLUMNS for grid in subject.grids)
    strips = plain and narrow and subject.device.facts.kind == "cpu"
    return _strips(subject, defines) if strips else _chunks(subject, defines)


def _chunks(subject: Any, defines: dict[str, int]) -> Launch:
    """Points and normals, vertex after vertex."""
    group = group_size(subject.device)
    if defines["CHUNK"] > LINE and not defines["STREAMING"]:
        defines["CHUNK"], group = LONG_CHUNK, min(LONG_GROUP, group)
    with subject.setup.host("build"):
        program = subject.device.build("nurbs/vertex.cl", defines=defines)
    return program.launch(
        "nurbs_vertex", -(-subject.vertices // defines["CHUNK"]), stage="vertex", local=group,
        **subject.buffers, positions=subject.positions, normals=subject.normals,
        stride=subject.buffers["places"].shape[1], surface_count=len(subject.model.surfaces),
        vertex_count=subject.vertices,
    )  # fmt: skip


def _strips(subject: Any, defines: dict[str, int]) -> Launch:
    """Points alone, of surfaces without weights; a rounding or two from those with normals beside them."""
    tiles = TILES * subject.device.facts.compute_units
    vertices = max(subject.vertices // tiles, TILE_VERTICES)
    with subject.setup.host("upload"):
        table = tiles_of(subject.grids, vertices)
        tiles = subject.upload("tiles", table, np.uint32, role="pattern")
    kept = {name: defines[name] for name in ("NORMALS", "RATIONAL", "STREAMING")}
    with subject.setup.host("build"):
        program = subject.device.build(
            "nurbs/strip.cl", defines=kept | {"TILE_COLUMNS": TILE_COLUMNS}
        )
    read = {name: subject.buffers[name] for name in ("surfaces", "samples", "weights", "controls")}
    return program.launch(
        "nurbs_strip", len(table), stage="vertex", local=1, tiles=tiles, **read,
        positions=subject.positions, stride=subject.buffers["places"].shape[1],
        tile_count=len(table),
    )  # fmt: skip
