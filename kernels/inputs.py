"""Meshes from what people have: arrays, files, and the objects of trimesh and pyvista."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.arrays import usable
from lodbench.datasets_gen.surfaces import TriangleMesh


def as_mesh(points: Any, faces: Any = None) -> TriangleMesh:
    """A TriangleMesh from what people have.

    Args:
        points: (n, 3) floats, with `faces`; or a mesh alone: TriangleMesh, (points, faces), the path of a mesh file,
            trimesh.Trimesh and trimesh.Scene (its meshes in their places, joined) or anything else with `vertices`
            and `faces`, or with `points` and `regular_faces` such as pyvista.PolyData. Normals that they hold, texture
            coordinates and colours of their vertices come along (of pyvista: RGB or RGBA), where they are finite.
        faces: (m, 3) integers.

    Raises:
        TypeError: none of these.
        ValueError: wrong shapes, NaN or infinity, an index out of range; FileError where a file cannot be read.
    """
    return taken(points, faces)[0]


def with_triangles(mesh: TriangleMesh) -> TriangleMesh:
    """The mesh itself; one of neither points nor triangles may pass.

    Raises:
        ValueError: points alone, of which nothing can be made.
    """
    if mesh.vertex_count and not mesh.triangle_count:
        raise ValueError(f"faces: expected triangles, got {mesh.vertex_count:,} points and none")
    return mesh


def taken(points: Any, faces: Any = None) -> tuple[TriangleMesh, type[np.floating]]:
    """`as_mesh`, and what its points are given back in: float32 where such came in, or float64."""
    attributes: dict[str, Any] = {}
    if faces is not None:
        pass
    elif isinstance(points, TriangleMesh):
        return points, np.float32 if points.origin is None else np.float64
    elif isinstance(points, str | os.PathLike):
        from lodbench.datasets_gen.read import read_mesh  # trimesh takes half a second

        return taken(read_mesh(points))
    elif hasattr(points, "geometry") and hasattr(points, "to_mesh"):  # trimesh.Scene
        return taken(points.to_mesh())
    elif hasattr(points, "vertices") and hasattr(points, "faces"):
        attributes = _of_trimesh(points)
        points, faces = points.vertices, points.faces
    elif hasattr(points, "points") and hasattr(type(points), "regular_faces"):
        attributes = _of_pyvista(points)
        points, faces = points.points, _regular_triangles(points)
    elif isinstance(points, tuple | list) and len(points) == 2:
        points, faces = points
    else:
        # pyvista's volumes
        volume = hasattr(points, "extract_surface")
        hint = ": call .extract_surface().triangulate() on it first" if volume else ""
        raise TypeError(
            "points: expected a mesh, the path of one, or points (n, 3) with faces (m, 3), "
            f"got {type(points).__name__}{hint}"
        )
    points = np.asarray(points)
    narrow = np.can_cast(points.dtype, np.float32)
    mesh = TriangleMesh(points, np.asarray(faces), **attributes)
    return mesh, np.float32 if narrow else np.float64


def _of_trimesh(mesh: Any) -> dict[str, Any]:
    """Attributes of a trimesh.Trimesh: colours of faces and textures are not taken, and normals not made."""
    visual: Any = getattr(mesh, "visual", None)
    kept: Any = getattr(getattr(mesh, "_cache", None), "cache", {})
    colours = getattr(visual, "vertex_attributes", {}).get("color")
    if getattr(visual, "kind", None) == "vertex":
        colours = visual.vertex_colors
    given = kept.get("vertex_normals"), getattr(visual, "uv", None), colours
    return _attributes(len(mesh.vertices), *given)


def _of_pyvista(mesh: Any) -> dict[str, Any]:
    """Attributes of a pyvista.PolyData, by the names that its readers give."""
    data: Any = getattr(mesh, "point_data", {})
    colours = next((data[name] for name in ("RGB", "RGBA") if name in data), None)
    uvs = getattr(mesh, "active_texture_coordinates", None)
    return _attributes(len(mesh.points), getattr(data, "active_normals", None), uvs, colours)


def _attributes(count: int, normals: Any, uvs: Any, colours: Any) -> dict[str, Any]:
    """Those of `count` vertices that can be used; colours 0..1, or whole numbers up to the largest of their type."""
    if colours is not None and (kind := np.asarray(colours).dtype).kind in "iu":
        colours = np.asarray(colours) / np.iinfo(kind).max
    return {
        "normals": usable(normals, count, 3), "uvs": usable(uvs, count, 2),
        "colours": usable(colours, count, 3),
    }  # fmt: skip


def _regular_triangles(mesh: Any) -> NDArray[np.integer]:
    """The triangles of a pyvista.PolyData.

    Raises:
        ValueError: it has other polygons.
    """
    try:
        found = np.asarray(mesh.regular_faces)
    except ValueError:
        got = "polygons of several sizes"
    else:
        if not found.size or found.shape[1] == 3:
            return found.reshape(-1, 3)
        got = f"polygons of {found.shape[1]} corners"
    raise ValueError(f"faces: expected triangles, got {got}: call .triangulate() on it first")
