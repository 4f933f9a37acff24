"""render: a picture of a mesh in one call, and what others draw pictures with."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lodbench.datasets_gen.finest import finest
from lodbench.datasets_gen.surfaces import BezierPatches, NurbsModel, TriangleMesh
from lodbench.kernels import verbs
from lodbench.kernels.api import open_device
from lodbench.kernels.inputs import as_mesh, with_triangles
from lodbench.kernels.opencl import Device, Timeline, Unsupported
from lodbench.kernels.parameters import Range, check
from lodbench.kernels.stages.camera import TABLE_SIZE, fit_points, moved
from lodbench.kernels.stages.raster import Raster, Side
from lodbench.kernels.stages.shading import Shading
from lodbench.kernels.system import NOTHING_TO_DRAW, DeviceSurface, Frame, View, run

MOST_PIXELS = 16384  # along a side, as drawn
COLOURS = ("smooth", "flat", "wireframe", "triangle", "vertex")
CAMERA = (30.0, 20.0)  # degrees: a little from the right, a little from above
UP = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def upload_surface(device: Device, mesh: TriangleMesh, normals: bool = True) -> DeviceSurface:
    """A mesh as a surface on the device; normals are made where it has none and they are asked for."""
    if normals:
        mesh = mesh.with_normals()
    return DeviceSurface(
        device.upload("positions", mesh.positions),
        device.upload("normals", mesh.normals) if mesh.normals is not None and normals else None,
        device.upload("triangles", mesh.triangles),
        mesh.vertex_count,
        mesh.triangle_count,
    )


def direction(camera: tuple[float, float], up: str) -> NDArray[np.float64]:
    """From a mesh to the eye at this azimuth and elevation, degrees: (3,), unit length."""
    check("up", up, Literal["x", "y", "z"])
    around, above = np.radians(check("camera", camera, tuple[float, float]))
    right = np.array((0.0, -1.0, 0.0) if up == "x" else UP["x"])
    front = np.cross(right, UP[up])
    level = right * np.sin(around) + front * np.cos(around)
    return level * np.cos(above) + np.array(UP[up]) * np.sin(above)


def mesh_view(
    mesh: TriangleMesh,
    camera: tuple[float, float] = CAMERA,
    size: tuple[int, int] = TABLE_SIZE,
    up: str = "y",
) -> View:
    """The nearest view that shows the whole mesh.

    Args:
        mesh: what to look at.
        camera: azimuth and elevation of the eye, degrees; (0, 0) looks at the front, (90, 0) at the right side.
        size: width and height, pixels.
        up: "x", "y" or "z", the axis that points upwards.

    Raises:
        ValueError: an unknown axis, a size out of range, or angles that are no numbers.
    """
    size = check("size", size, tuple[Side, Side])
    towards = direction(camera, up)
    points = mesh.positions if mesh.vertex_count else np.zeros((1, 3))
    view = fit_points(points, towards, size, up=UP[up])
    return view if mesh.origin is None else moved(view, mesh.origin)


def colour_table(name_or_colours: str | ArrayLike) -> NDArray[np.float32]:
    """(256, 3) float32 linear colours, of a matplotlib colour map or of an (n, 3) table of 0..1 screen colours.

    Raises:
        ValueError: no such map, or another shape.
    """
    if isinstance(name_or_colours, str):
        from matplotlib import colormaps

        if name_or_colours not in colormaps:
            raise ValueError(
                f"colour_map: expected a matplotlib colour map, got {name_or_colours!r}"
            )
        table = colormaps[name_or_colours](np.linspace(0, 1, 256))[:, :3]
    else:
        given = np.asarray(name_or_colours, np.float64)
        if given.ndim != 2 or given.shape[1] != 3 or not len(given) or not np.isfinite(given).all():
            raise ValueError(f"colour_map: expected (n, 3) colours, got shape {given.shape}")
        at = np.linspace(0, len(given) - 1, 256)
        table = np.stack([np.interp(at, np.arange(len(given)), c) for c in given.T], axis=1)
    return (np.clip(table, 0, 1) ** 2).astype(np.float32)  # the fragment stage ends with a root


def shading_of(
    mesh: TriangleMesh,
    colour: str | ArrayLike,
    wireframe: bool,
    cull: bool,
    colour_map: str | ArrayLike,
    colour_range: tuple[float, float] | None,
) -> Shading:
    """How `render` draws, by its arguments and its errors."""
    wireframe, cull = check("wireframe", wireframe, bool), check("cull", cull, bool)
    colour_range = check("colour_range", colour_range, tuple[float, float] | None)
    if isinstance(colour, str):
        if colour not in COLOURS:
            raise ValueError(
                f"colour: expected one of {', '.join(COLOURS)}, or values, got {colour!r}"
            )
        values = mesh.colours if colour == "vertex" else None
        if colour == "vertex" and values is None:
            raise ValueError("colour: expected a mesh with vertex colours for 'vertex', got none")
        return Shading(
            smooth=colour in ("smooth", "vertex"),
            wireframe=wireframe or colour == "wireframe",
            by_triangle=colour == "triangle",
            # screen colours become light, as in `colour_table`
            values=None if values is None else np.clip(values, 0, 1) ** 2,
            cull=cull,
        )
    values = np.asarray(colour, np.float64)
    counts = {"vertices": mesh.vertex_count, "triangles": mesh.triangle_count}
    owner = next((name for name, n in counts.items() if values.shape == (n,)), None)
    if owner is None:
        raise ValueError(
            f"colour: expected ({mesh.vertex_count},) values of points or ({mesh.triangle_count},) "
            f"of faces, got shape {values.shape}"
        )
    if not np.isfinite(values).all():
        raise ValueError("colour: expected finite values, got NaN or infinity")
    low, high = colour_range or ((values.min(), values.max()) if values.size else (0.0, 1.0))
    span = high / 2 - low / 2  # halves: the whole may be more than float64 holds
    unit = (values / 2 - low / 2) / span if span > 0 else np.zeros_like(values)
    return Shading(
        wireframe=wireframe,
        values=np.clip(unit, 0, 1).astype(np.float32),
        values_of=owner,
        colour_map=colour_table(colour_map),
        cull=cull,
    )


def render(
    points: Any,
    faces: Any = None,
    camera: View | tuple[float, float] | None = None,
    size: tuple[int, int] = TABLE_SIZE,
    colour: str | ArrayLike = "smooth",
    *,
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
    """A picture of a mesh, (height, width, 3) uint8.

    Args:
        points: (n, 3) floats, or a mesh alone: see `as_mesh`; or Bezier patches or a NURBS model.
        faces: (m, 3) integers.
        camera: a `View` of the world (its size is the picture's), or azimuth and elevation in degrees; None: (30, 20).
        size: width and height, pixels, 1 to 16384 each.
        colour: "smooth", "flat", "wireframe" (flat, with edges), "triangle" (a colour for each), "vertex" (the mesh's
            own colours), or values, (n,) per point or (m,) per face, shown through the colour map.
        wireframe: draw the edges over whatever colour.
        cull: leave out faces that turn away.
        samples: per pixel and axis: 2 draws at twice the size and takes the mean of four pixels.
        up: "x", "y" or "z", the axis that points upwards where the camera is not a `View`.
        colour_map: of matplotlib, or (n, 3) colours 0..1.
        colour_range: the values at its ends; None: the least and the largest.
        refine: a system with the verb refine: what is drawn is the mesh as it refines it for this view, on the device.
            Of patches and NURBS models one with the verb tessellate; None: the first that takes them.
        device: an open device, a name for `Device.open`, or None for the default.
        **options: of that system's Params, such as segments, surface and by of adaptive patterns, level of patches.

    Raises:
        TypeError, ValueError: an argument is wrong.
        Unsupported: the device cannot hold the mesh or the image.
    """
    mesh, surface = looked_at(points, faces)
    if not isinstance(camera, View):  # seen from near by, where no digits are lost
        view = mesh_view(mesh.with_origin(None), camera or CAMERA, size, up)
    else:
        view = camera if mesh.origin is None else moved(camera, -mesh.origin)
    shading = shading_of(mesh, colour, wireframe, cull, colour_map, colour_range)
    opened = open_device(device)
    drawn = drawn_surfaces(opened, surface, shading, refine, options)
    (image,) = pictures(opened, drawn, [view], shading, samples)
    return image


Curved = BezierPatches | NurbsModel


def looked_at(points: Any, faces: Any) -> tuple[TriangleMesh, TriangleMesh | Curved]:
    """What is to be seen as a mesh, which a camera is placed by, and as what it is."""
    if isinstance(points, Curved) and faces is None:
        return finest(points), points
    mesh = with_triangles(as_mesh(points, faces))
    return mesh, mesh


Drawn = Callable[[View], Sequence[DeviceSurface]]
"""What is drawn of a view, made for it if need be."""


def drawn_surfaces(
    device: Device,
    mesh: TriangleMesh | Curved,
    shading: Shading,
    refine: str | None,
    options: Mapping[str, Any],
) -> Drawn:
    """The mesh itself, or as a system refines or tessellates it for each view.

    Raises:
        TypeError, ValueError: an unknown system or option, or values that colour a mesh that is refined.
        Unsupported: the device cannot hold the mesh.
    """
    if refine is None and isinstance(mesh, TriangleMesh):
        if options:
            raise TypeError(
                f"{next(iter(options))}: expected with refine, the system whose option it is"
            )
        surface = upload_surface(device, mesh, normals=shading.smooth)
        return lambda view: [surface]
    if shading.values is not None:
        raise ValueError("colour: expected no values where the mesh is refined, got some")
    verb = "refine" if isinstance(mesh, TriangleMesh) else "tessellate"
    system = verbs.answering(verb, check("refine", refine, str | None), mesh)
    kind = type(next(iter(system.cases.values())))
    prepared = system.prepare(device, mesh, kind.named(**options))

    def refined(view: View) -> Sequence[DeviceSurface]:
        run(device, prepared, Frame(view))
        if not prepared.output:
            raise Unsupported(NOTHING_TO_DRAW)
        return prepared.output

    return refined


def pictures(
    device: Device, drawn: Drawn, views: Sequence[View], shading: Shading, samples: int
) -> Iterator[NDArray[np.uint8]]:
    """What each view sees, all of one size, `samples` squared points per pixel."""
    width, height = views[0].width, views[0].height
    most = Range(1, max(MOST_PIXELS // max(width, height), 1))
    samples = check("samples", samples, Annotated[int, most])
    shading = replace(shading, line_width=shading.line_width * samples)
    raster = None
    for view in views:
        surfaces = drawn(view)
        if raster is None:
            raster = Raster(device, surfaces, width * samples, height * samples, shading)
        larger = replace(view, width=width * samples, height=height * samples)
        raster(surfaces, Frame(larger), Timeline())
        yield _mean(raster.image(), samples)


def _mean(image: NDArray[np.uint8], samples: int) -> NDArray[np.uint8]:
    """Each block of samples x samples pixels as one, averaged as light: the image holds roots."""
    if samples == 1:
        return image
    height, width = image.shape[0] // samples, image.shape[1] // samples
    rows = image.reshape(height, samples, width, samples, 3)
    total = np.zeros((height, width, 3), np.uint32)
    for y in range(samples):
        for x in range(samples):
            total += rows[:, y, :, x].astype(np.uint32) ** 2
    return (np.sqrt(total / samples**2) + 0.5).astype(np.uint8)
