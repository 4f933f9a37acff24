"""simplify, refine and their kin: arrays in, arrays out, one call."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import BezierPatches, GeometryImage, NurbsModel, TriangleMesh
from lodbench.kernels import verbs
from lodbench.kernels.inputs import as_mesh, taken, with_triangles
from lodbench.kernels.opencl import Device
from lodbench.kernels.parameters import check
from lodbench.kernels.result import Result
from lodbench.kernels.targets import given_targets

Points = NDArray[np.floating]  # float32 where such came in, else float64
Faces = NDArray[np.uint32]


@cache
def _default_device(name: str | None) -> Device:
    """The device that calls without one share, opened once."""
    return Device.open(name)


def open_device(device: Device | str | None) -> Device:
    """`device` itself, or the one of that name, or the default: opened once and kept open."""
    if isinstance(device, Device):
        return device
    return _default_device(check("device", device, str | None))


def _check_method(method: object) -> None:
    """Refuse what is no name; names and None at once, since to make the union of them takes as long as a launch."""
    if method is not None and type(method) is not str:
        check("method", method, str | None)


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
    max_error: float | None = None,
    method: str | None = None,
    **options: Any,
) -> Result:
    """Fewer triangles of the same shape, with everything that is known about them.

    Args:
        device: an open device, a name for `Device.open`, or None for the default, which stays open.
        mesh: see `as_mesh`; or a `GeometryImage`.
        target_reduction: share of triangles removed, 0 to below 1; 0.9 leaves a tenth, 0 the mesh as it came.
        target_count: triangles left at most; the result has at least 95 % of them, or `counters` says by how much it
            misses: `target_gap`, triangles short of `target`, negative where a method can leave no fewer but none.
        cells: cells along the longest box axis (cubic cells), or (nx, ny, nz); at most 2**27 in all.
        max_error: as a share of the bounding-box diagonal, of a method that keeps to one; beside another target for
            edge_collapse, which stops at what is met first.
        method: a system's name, of those with the verb simplify; None takes "auto" for a mesh: by size, target and
            options one of them, and `counters` say which and why.
        **options: the method's own, those of its Params, such as placement="average"; of a clustering also
            attributes=False, which leaves out the normals, uvs, colours and tags that come along otherwise, and
            remove_flipped=True (see `kernels/cluster/prepare.py`).

    Returns:
        The result; its mesh holds only vertices that a triangle uses, unless it is the mesh as it came. At seams of
        its attributes it has a vertex for each side, at the same place to the bit.

    Raises:
        TypeError, ValueError: an argument is wrong; not exactly one of the targets.
        Unsupported: the device cannot hold the mesh.
    """
    _check_method(method)
    surface = mesh if isinstance(mesh, GeometryImage) else with_triangles(as_mesh(mesh))
    chosen = verbs.method("simplify", method, surface)
    targets = {
        "target_reduction": target_reduction, "target_count": target_count, "cells": cells,
        "max_error": max_error,
    }  # fmt: skip
    result = chosen(open_device(device), surface, **given_targets(targets), **options)
    return _placed(result, surface)


def simplify(
    points: Any,
    faces: Any = None,
    target_reduction: float | None = None,
    *,
    target_count: int | None = None,
    cells: int | float | tuple[int, int, int] | None = None,
    max_error: float | None = None,
    method: str | None = None,
    device: Device | str | None = None,
    **options: Any,
) -> tuple[Points, Faces]:
    """Fewer triangles of the same shape: (points, faces) of the simplified mesh.

    The first three arguments are those of `fast_simplification.simplify`; the rest, and the errors, are those of
    `simplify_mesh`, which also returns the map from input to output vertices, and carries normals, uvs and colours,
    which are left out here. A closed manifold stays one, of the same genus. Where the mesh has borders, points on them
    at the same place are joined first, so that an STL file's triangles hang together; others are left apart. A
    `GeometryImage` may stand in for points and faces.

    Returns:
        points (n, 3), float32 where such came in and else float64, and faces (m, 3) uint32.
    """
    if isinstance(points, GeometryImage):
        surface, dtype = points, np.float32 if points.origin is None else np.float64
    else:
        surface, dtype = taken(points, faces)
    if isinstance(surface, TriangleMesh):  # no vertex is split for what is not given back
        surface = surface.bare()
    result = simplify_mesh(
        device,
        surface,
        target_reduction=target_reduction,
        target_count=target_count,
        cells=cells,
        max_error=max_error,
        method=method,
        **options,
    )
    return result.mesh.points.astype(dtype, copy=False), result.mesh.triangles


def refine_mesh(
    device: Device | str | None,
    mesh: Any,
    *,
    segments: int = 4,
    method: str | None = None,
    weld: bool = True,
    **options: Any,
) -> Result:
    """Each triangle split into segments**2, displaced where asked.

    Args:
        device: an open device, a name for `Device.open`, or None for the default, which stays open.
        mesh: see `as_mesh`; normals are made where it has none.
        segments: segments along each edge, at least 1.
        method: a system's name, of those with the verb refine; None takes the preferred one.
        weld: share the points on edges and corners between triangles; False leaves each coarse triangle its own.
        **options: the method's own, those of its Params, such as displacement, amplitude and waves.

    Raises:
        TypeError, ValueError: an argument is wrong.
        Unsupported: the device cannot hold the result.
    """
    _check_method(method)
    coarse = with_triangles(as_mesh(mesh))
    chosen = verbs.method("refine", method, coarse)
    result = chosen(open_device(device), coarse, segments=segments, weld=weld, **options)
    return _placed(result, coarse)


def refine(
    points: Any,
    faces: Any = None,
    segments: int = 4,
    *,
    method: str | None = None,
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


def _curved(surface: Any) -> BezierPatches | NurbsModel:
    """Control points (n, 4, 4, 3) as Bezier patches; surfaces as they are."""
    if isinstance(surface, np.ndarray | list | tuple):
        return BezierPatches(surface)
    return surface


def tessellate_surface(
    device: Device | str | None,
    surface: Any,
    *,
    method: str | None = None,
    **options: Any,
) -> Result:
    """Triangles of a curved surface, with everything that is known about them.

    Args:
        device: an open device, a name for `Device.open`, or None for the default, which stays open.
        surface: Bezier patches or a NURBS model; control points of bicubic patches, (n, 4, 4, 3), are taken too.
        method: a system's name, of those with the verb tessellate; None takes the preferred one.
        **options: the method's own, those of its Params, such as level=4; weld=False leaves each patch its own points.

    Raises:
        TypeError, ValueError: an argument is wrong, or no system takes the surface.
        Unsupported: the device cannot hold the result.
    """
    _check_method(method)
    surface = _curved(surface)
    by_screen = options.get("view") is not None or "pixel_area" in options
    chosen = verbs.method("tessellate", method, surface, by_screen)
    return chosen(open_device(device), surface, **options)


def tessellate(
    surface: Any,
    *,
    method: str | None = None,
    device: Device | str | None = None,
    **options: Any,
) -> tuple[Points, Faces]:
    """Triangles of a curved surface: (points, faces), (n, 3) float32 and (m, 3) uint32.

    The arguments and errors are those of `tessellate_surface`.
    """
    result = tessellate_surface(device, surface, method=method, **options)
    return result.mesh.points, result.mesh.triangles
