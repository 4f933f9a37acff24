"""Quadric clustering of pieces of a mesh on the workers of a Dask cluster, merged to what one makes of the whole.

Sums are integers, which add up the same in any order, and a piece's triangles keep their order: so neither the number
of workers nor where a piece is worked on, or how often because a worker died, changes a byte of the result. It is that
of `accumulate="fixed_point"` for the pieces as one mesh, one after the other.

Source: Lindstrom 2000, Out-of-Core Simplification of Large Polygonal Models; quadrics are additive.
"""

from __future__ import annotations

import importlib
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.batches import Batch
from lodbench.datasets_gen.surfaces import Indices, TriangleMesh
from lodbench.kernels.api import open_device
from lodbench.kernels.cluster.borders import NO_EDGES, candidates, places, single
from lodbench.kernels.cluster.grid import Cells, Grid
from lodbench.kernels.cluster.quadric_clustering import Params
from lodbench.kernels.cluster.quadric_clustering.batches import Batches
from lodbench.kernels.cluster.upload import Upload
from lodbench.kernels.cluster.warped import WARPS
from lodbench.kernels.inputs import as_mesh
from lodbench.kernels.opencl import Device

Box = tuple[Sequence[float], Sequence[float]]

_device_in_use = threading.Lock()
"""Threads of one worker share its device, whose launches are not theirs to mix."""


class _Measured(NamedTuple):
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    vertices: int
    triangles: int


class _Summed(NamedTuple):
    """Sums (r, 14) of the ranks (r,) of cells that a piece has corners in; its triangles left, as ranks, (s, 3)."""

    ranks: NDArray[np.int64]
    sums: NDArray[np.int64]
    left: NDArray[np.uint32]


def simplify(
    pieces: Sequence[Any],
    client: Any,
    *,
    cells: Cells,
    box: Box | None = None,
    device: Device | str | None = None,
    **options: Any,
) -> TriangleMesh:
    """The mesh made of `pieces`, one after the other, simplified on a grid.

    Each piece goes over the network once for each of four passes (paths alone, where pieces are files that all workers
    see); back come where its border edges lie, a bit per cell, then sums of its occupied cells and its triangles left.
    A worker that dies loses nothing but time: Dask runs its pieces anew elsewhere. An edge where pieces meet is no
    border: it lies in two.

    Args:
        pieces: meshes as `as_mesh` takes them, such as (points, faces) or the path of a file; points on a seam stand in
            each piece that uses them.
        client: a `distributed.Client`.
        cells: the grid.
        box: its lower and upper corner, (3,) each, which all points must lie in; None takes that of all points.
        device: where the merged sums are solved, here.
        **options: those of the system's Params; not how far, nor remove_duplicates, border="keep" or a warp.

    Returns:
        The simplified mesh; the bytes of `simplify_mesh(..., accumulate="fixed_point")` of the whole.

    Raises:
        ImportError: dask.distributed is not installed.
        TypeError, ValueError: an argument or a piece is wrong, or does not lie in the box.
        Unsupported: the device or a worker's has no 64-bit atomics, or no room.
    """
    distributed = _distributed()
    params = Params.named(**{"cells": cells, "accumulate": "fixed_point"} | options)
    if params.accumulate != "fixed_point" or params.remove_duplicates:
        raise ValueError(
            "accumulate, remove_duplicates: expected 'fixed_point' and False, "
            f"got {params.accumulate!r} and {params.remove_duplicates}"
        )
    if params.keeps_border or any(getattr(params, name) for name in WARPS):
        raise ValueError("border, regions, view, warp: expected no keep and no warp, got one")
    if params.triangles(1) is not None:
        raise ValueError("cells: expected a grid, got a number of triangles")

    def each(
        work: Callable[..., Any], *more: Any, own: Sequence[Any] | None = None
    ) -> Iterator[tuple[int, Any]]:
        """What `work` makes of each piece, of `own` of the piece and of `more`, as it comes, with its number."""
        owns = [() for _ in pieces] if own is None else [(value,) for value in own]
        futures = [
            client.submit(work, piece, *value, *more, pure=False)
            for piece, value in zip(pieces, owns, strict=True)
        ]
        number = {future.key: i for i, future in enumerate(futures)}
        try:
            for future in distributed.as_completed(futures):
                yield number[future.key], future.result()
                future.release()
        finally:
            client.cancel(futures)

    measured = [found for _, found in each(_measure)]
    triangles = sum(found.triangles for found in measured)
    full = [found for found in measured if found.vertices]
    whole = tuple(np.zeros(3) for _ in range(2))
    if full:
        whole = np.min([m.low for m in full], 0), np.max([m.high for m in full], 0)
    low, high = whole if box is None else tuple(np.asarray(corner, np.float64) for corner in box)
    if (low > whole[0]).any() or (high < whole[1]).any():
        raise ValueError(f"box: expected one around {whole[0]} to {whole[1]}, got {low} to {high}")
    grid = Grid.over(low, high, params.grid_cells)
    borders: list[NDArray[np.bool_]] = [np.zeros(0, bool) for _ in pieces]
    if params.holds_border:
        borders = _borders(dict(each(_open_edges)))
    marked: NDArray[np.uint8] | None = None
    exponents = np.zeros((2, 256))
    for _, (bits, counts) in each(_mark, grid, params, own=borders):
        marked = bits if marked is None else marked | bits
        exponents += counts
    merged = Batches(open_device(device), grid, params, triangles, marked)
    merged.rank()
    merged.scale(*exponents)
    sums = merged.sums()
    left: dict[int, NDArray[np.uint32]] = {}
    for number, found in each(
        _sum, grid, params, triangles, _scattered(client, marked), exponents, own=borders
    ):
        sums[found.ranks] += found.sums
        left[number] = found.left
    merged.merged(sums)
    vertices, new_ranks = merged.solve()
    ranks = np.concatenate([np.zeros((0, 3), np.uint32), *(left[i] for i in range(len(left)))])
    return TriangleMesh(vertices, new_ranks[ranks])


def _distributed() -> Any:
    try:
        return importlib.import_module("distributed")
    except ImportError:
        raise ImportError(
            'needs dask.distributed, this environment has none: pip install "lodbench[dask]"'
        ) from None


def _scattered(client: Any, values: Any) -> Any:
    """On all workers, sent once."""
    return client.scatter(values, broadcast=True, hash=False)


def _borders(found: Mapping[int, NDArray[np.float32]]) -> list[NDArray[np.bool_]]:
    """Which of each piece's open edges, given by where their ends lie, (k, 2, 3), are open in the whole."""
    ends = [found[number] for number in range(len(found))]
    joined = np.concatenate([np.zeros((0, 2, 3), np.float32), *ends])
    alone = single(places(joined.reshape(-1, 3)).reshape(-1, 2))
    return np.split(alone, np.cumsum([len(own) for own in ends]))[:-1]


# on a worker; a piece is read anew in each pass, so that none of them is kept


def _mesh(piece: Any) -> TriangleMesh:
    mesh = as_mesh(piece)
    if mesh.origin is not None:
        raise ValueError(
            f"pieces: expected points near zero for their extent, or float32, got some about {mesh.origin}"
        )
    return mesh


def _measure(piece: Any) -> _Measured:
    mesh = _mesh(piece)
    return _Measured(*mesh.box, mesh.vertex_count, mesh.triangle_count)


def _open(mesh: TriangleMesh) -> Indices:
    """The edges that one triangle of the piece uses alone, (k, 3) as `border_edges` has them: seams are among them."""
    upload = Upload(open_device(None), mesh)
    found = candidates(upload.device, upload.program, upload.triangles, mesh.vertex_count)
    return found[single(found[:, :2])]


def _open_edges(piece: Any) -> NDArray[np.float32]:
    """Where the ends of the open edges lie, (k, 2, 3)."""
    mesh = _mesh(piece)
    with _device_in_use:
        return mesh.positions[_open(mesh)[:, :2]]


def _border(mesh: TriangleMesh, border: NDArray[np.bool_]) -> Batch:
    """Those of a piece's open edges that `border` says, as its triangles."""
    return Batch(mesh.positions, _open(mesh)[border] if border.any() else NO_EDGES)


def _mark(
    piece: Any, border: NDArray[np.bool_], grid: Grid, params: Params
) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
    """A bit per cell; triangles by the exponent of their area, border edges by that of their length's square."""
    mesh = _mesh(piece)
    with _device_in_use:
        work = Batches(open_device(None), grid, params, mesh.triangle_count)
        if mesh.vertex_count:
            work.mark(mesh.positions)
        marked = work.marked()
        work.rank()
        areas = work.exponents(mesh.positions, mesh.triangles)
        return marked, np.stack([areas, work.border_exponents(_border(mesh, border))])


def _sum(
    piece: Any,
    border: NDArray[np.bool_],
    grid: Grid,
    params: Params,
    triangles: int,
    marked: NDArray[np.uint8],
    exponents: NDArray[np.float64],
) -> _Summed:
    mesh = _mesh(piece)
    with _device_in_use:
        work = Batches(open_device(None), grid, params, triangles, marked)
        work.rank()
        work.scale(*exponents)
        left = work.accumulate(mesh.positions, mesh.triangles)
        if len((edges := _border(mesh, border)).triangles):
            work.hold_border(edges, 0, len(edges.triangles))
        sums = work.sums()
    ranks = np.flatnonzero(sums.any(axis=1))
    return _Summed(ranks, sums[ranks], left)
