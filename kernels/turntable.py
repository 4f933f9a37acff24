"""turntable: pictures of a mesh from all around, or along a camera path, in one call."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.api import open_device
from lodbench.kernels.opencl import Device
from lodbench.kernels.parameters import Range, check
from lodbench.kernels.render import (
    CAMERA,
    UP,
    direction,
    drawn_surfaces,
    looked_at,
    pictures,
    shading_of,
)
from lodbench.kernels.stages.camera import distance_to_show, look_at
from lodbench.kernels.stages.paths import CameraPath
from lodbench.kernels.stages.raster import Side
from lodbench.kernels.system import View

Path = Literal["turntable", "orbit", "fly_through"]


def turntable(
    points: Any,
    faces: Any = None,
    frames: int = 36,
    camera: tuple[float, float] = CAMERA,
    size: tuple[int, int] = (640, 512),
    colour: str | ArrayLike = "smooth",
    *,
    path: Path = "turntable",
    wireframe: bool = False,
    cull: bool = False,
    samples: int = 2,
    up: str = "y",
    colour_map: str | ArrayLike = "viridis",
    colour_range: tuple[float, float] | None = None,
    refine: str | None = None,
    device: Device | str | None = None,
    **options: Any,
) -> NDArray[np.uint8]:
    """Pictures of a mesh from all around, (frames, height, width, 3) uint8, from one distance that shows it whole.

    Args:
        frames: how many, 1 to 1,000, in equal steps of azimuth from that of `camera` on.
        camera: azimuth of the first and elevation of all, degrees.
        path: "turntable"; or along a `CameraPath`, whose camera is its own: "orbit", around while the eye draws back to
            16 times the distance and returns; "fly_through", from there through the middle and as far again.
        refine: a system with the verb refine, or of patches tessellate, which does so anew for each picture, on the
            device.

    The other arguments and errors are those of `render`.
    """
    frames = check("frames", frames, Annotated[int, Range(1, 1000)])
    size, path = check("size", size, tuple[Side, Side]), check("path", path, Path)
    mesh, surface = looked_at(points, faces)
    mesh = mesh.with_origin(None)
    if path == "turntable":
        views = _around(mesh, frames, camera, size, up)
    else:
        views = CameraPath(path, max(frames, 2)).views(*mesh.box, size=size)[:frames]
    shading = shading_of(mesh, colour, wireframe, cull, colour_map, colour_range)
    opened = open_device(device)
    drawn = drawn_surfaces(
        opened, mesh if isinstance(surface, TriangleMesh) else surface, shading, refine, options
    )
    return np.stack(list(pictures(opened, drawn, views, shading, samples)))


def _around(
    mesh: TriangleMesh, frames: int, camera: tuple[float, float], size: tuple[int, int], up: str
) -> Sequence[View]:
    """A full turn, from the least distance that shows the mesh whole in all views."""
    around, above = check("camera", camera, tuple[float, float])
    low, high = mesh.box if mesh.vertex_count else (np.zeros(3), np.zeros(3))
    middle = (np.asarray(low, np.float64) + np.asarray(high, np.float64)) / 2
    points = mesh.positions if mesh.vertex_count else np.zeros((1, 3))
    ways = [direction((around + 360 * k / frames, above), up) for k in range(frames)]
    away = max(distance_to_show(points, middle, way, size, up=UP[up]) for way in ways)
    return [look_at(middle + away * way, middle, UP[up], size=size) for way in ways]
