"""simplify, refine and their kin: arrays in, arrays out, one call."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import GeometryImage, TriangleMesh
from lodbench.kernels.device import Device
from lodbench.kernels.inputs import as_mesh, taken, with_triangles
from lodbench.kernels.parameters import check
from lodbench.kernels.stages.timeline import Timeline
from lodbench.kernels.targets import given_target

Points = NDArray[np.floating]  # float32 where such came in, else float64
Faces = NDArray[np.uint32]


@dataclass(frozen=True, eq=False)
class Result:
    """What simplifying or refining a mesh gave.

    Attributes:
        mesh: the mesh, float32 positions from the origin of the input, and uint32 triangles, with normals where the
            method makes them.
        vertex_map: (n,) uint32, the output vertex of each input vertex, 0xFFFFFFFF where there is none; None where
            vertices do not map one to one.
        levels: all levels of a chain, coarsest last; (mesh,) where there is one.
        counters: sizes and choices of the method, by name.
        setup, frame: where the time went, seconds by stage.
    """

    mesh: TriangleMesh
    vertex_map: NDArray[np.uint32] | None = None
    levels: tuple[TriangleMesh, ...] = ()
    counters: dict[str, int | float] = field(default_factory=dict)
    setup: Timeline = field(default_factory=Timeline)
    frame: Timeline = field(default_factory=Timeline)


@cache
def _default_device(name: str | None) -> Device:
    """The device that calls without one share, opened once."""
    return Device.open(name)


def open_device(device: Device | str | None) -> Device:
    """`device` itself, or the one of that name, or the default: opened once and kept open."""
    if isinstance(device, Device):
        return device
    return _default_device(check("device", device, str | None))


@cache
def _method(verb: str, name: str) -> Callable[..., Result]:
    """The function `verb` of the system in the folder `name`; others are imported only to say which there are."""
    folders = {
        path.parent.name: path.parent for path in Path(__file__).parent.glob("*/*/__init__.py")
    }

    def function(folder: Path) -> Callable[..., Result] | None:
        package = f"lodbench.kernels.{folder.parent.name}.{folder.name}"
        candidate = getattr(importlib.import_module(package), verb, None)
        return candidate if callable(candidate) else None

    found = function(folders[name]) if name in folders else None
    if found is None:
        able = ", ".join(other for other in sorted(folders) if function(folders[other]))
        raise ValueError(f"method: expected one of {able}, got {name!r}")
    return found


def _placed(result: Result, surface: TriangleMesh | GeometryImage) -> Result:
    """The result about its input's origin; methods work on positions alone."""
    if surface.origin is None:
        return result
    levels = tuple(level.with_origin(surface.origin) for level in result.levels)
    return replace(result, mesh=result.mesh.with_origin(surface.origin), levels=levels)


def simplify_mesh(
    device: Device | str | None,
    mesh: Any,
    *,
    target_reduction: float | None = None,
    target_count: int | None = None,
    cells: int | float | tuple[int, int, int] | None = None,
    method: str = "quadric_clustering",
    **options: Any,
) -> Result:
    """Fewer triangles of the same shape, with everything that is known about them.

    Args:
        device: an open device, a name for `Device.open`, or None for the default, which stays open.
        mesh: see `as_mesh`; or, with method="quadtree_lod", a `GeometryImage`.
        target_reduction: share of triangles removed, 0 to below 1; 0.9 leaves a tenth, 0 the mesh as it came.
        target_count: triangles left at most; the result has at least 95 % of them, or `counters` says by how much it
            misses: `target_gap`, triangles short of `target`, negative where a method can leave no fewer but none.
        cells: cells along the longest box axis (cubic cells), or (nx, ny, nz); at most 2**27 in all.
        method: a system's name, such as "quadric_clustering".
        **options: the method's own, such as placement="average".

    Returns:
        The result; its mesh holds only vertices that a triangle uses, unless it is the mesh as it came.

    Raises:
        TypeError, ValueError: an argument is wrong; not exactly one of target_reduction, target_count and cells.
        Unsupported: the device cannot hold the mesh.
    """
    chosen = _method("simplify", check("method", method, str))
    surface = mesh if isinstance(mesh, GeometryImage) else with_triangles(as_mesh(mesh))
    if isinstance(surface, GeometryImage) and method != "quadtree_lod":
        raise TypeError(f"method: expected quadtree_lod for a geometry image, got {method!r}")
    targets = {"target_reduction": target_reduction, "target_count": target_count, "cells": cells}
    if given_target(targets) is None:
        raise ValueError(f"{', '.join(targets)}: expected one of them, got none")
    result = chosen(open_device(device), surface, **targets, **options)
    return _placed(result, surface)


def simplify(
    points: Any,
    faces: Any = None,
    target_reduction: float | None = None,
    *,
    target_count: int | None = None,
    cells: int | float | tuple[int, int, int] | None = None,
    method: str = "quadric_clustering",
    device: Device | str | None = None,
    **options: Any,
) -> tuple[Points, Faces]:
    """Fewer triangles of the same shape: (points, faces) of the simplified mesh.

    The first three arguments are those of `fast_simplification.simplify`; the rest, and the errors, are those of
    `simplify_mesh`, which also returns the map from input to output vertices. With method="quadtree_lod" a
    `GeometryImage` may stand in for points and faces.

    Returns:
        points (n, 3), float32 where such came in and else float64, and faces (m, 3) uint32.
    """
    if isinstance(points, GeometryImage):
        surface, dtype = points, np.float32 if points.origin is None else np.float64
    else:
        surface, dtype = taken(points, faces)
    result = simplify_mesh(
        device,
        surface,
        target_reduction=target_reduction,
        target_count=target_count,
        cells=cells,
        method=method,
        **options,
    )
    return result.mesh.points.astype(dtype, copy=False), result.mesh.triangles


def refine_mesh(
    device: Device | str | None,
    mesh: Any,
    *,
    segments: int = 4,
    method: str = "pattern",
    weld: bool = True,
    **options: Any,
) -> Result:
    """Each triangle split into segments**2, displaced where asked.

    Args:
        device: an open device, a name for `Device.open`, or None for the default, which stays open.
        mesh: see `as_mesh`; normals are made where it has none.
        segments: segments along each edge, at least 1.
        method: a system's name, such as "pattern".
        weld: share the points on edges and corners between triangles; False leaves each coarse triangle its own.
        **options: the method's own, such as amplitude and frequency.

    Raises:
        TypeError, ValueError: an argument is wrong.
        Unsupported: the device cannot hold the result.
    """
    chosen = _method("refine", check("method", method, str))
    coarse = with_triangles(as_mesh(mesh))
    result = chosen(open_device(device), coarse, segments=segments, weld=weld, **options)
    return _placed(result, coarse)


def refine(
    points: Any,
    faces: Any = None,
    segments: int = 4,
    *,
    method: str = "pattern",
    device: Device | str | None = None,
    weld: bool = True,
    **options: Any,
) -> tuple[Points, Faces]:
    """Each triangle split into segments**2: (points, faces) of the refined mesh.

    The arguments and errors are those of `refine_mesh`.

    Returns:
        points (n, 3), float32 where such came in and else float64, and faces (m, 3) uint32.
    """
    mesh, dtype = taken(points, faces)
    result = refine_mesh(device, mesh, segments=segments, method=method, weld=weld, **options)
    return result.mesh.points.astype(dtype, copy=False), result.mesh.triangles
