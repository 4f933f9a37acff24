"""Meshes given back as what they came as: arrays, and the objects of trimesh and pyvista."""

from __future__ import annotations

from typing import Any

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh


def as_given(mesh: TriangleMesh, given: Any) -> Any:
    """The mesh as an object of the kind of `given`, with its normals, texture coordinates and colours.

    Args:
        mesh: what is given back.
        given: TriangleMesh, (points, faces), trimesh.Trimesh (whose material stays where there are texture
            coordinates) or pyvista.PolyData: anything of `as_mesh` but a path and a Scene.

    Raises:
        TypeError: none of these.
    """
    if isinstance(given, TriangleMesh):
        return mesh
    if isinstance(given, tuple | list) and len(given) == 2:
        return mesh.points, mesh.triangles
    if hasattr(given, "vertices") and hasattr(given, "faces") and hasattr(given, "visual"):
        return _trimesh(mesh, given)
    if hasattr(given, "points") and hasattr(type(given), "from_regular_faces"):
        return _pyvista(mesh, given)
    raise TypeError(
        "given: expected a TriangleMesh, (points, faces), a trimesh.Trimesh or a pyvista.PolyData, "
        f"got {type(given).__name__}"
    )


def _trimesh(mesh: TriangleMesh, given: Any) -> Any:
    colours = _bytes(mesh.colours)
    made = type(given)(
        vertices=mesh.points, faces=mesh.triangles.astype(np.int64), vertex_normals=mesh.normals,
        vertex_colors=colours, process=False,
    )  # fmt: skip
    if mesh.uvs is not None:
        material = getattr(given.visual, "material", None)
        made.visual = type(given.visual)(uv=mesh.uvs.astype(np.float64), material=material)
        if colours is not None:
            made.visual.vertex_attributes["color"] = colours
    return made


def _pyvista(mesh: TriangleMesh, given: Any) -> Any:
    made = type(given).from_regular_faces(mesh.points, mesh.triangles.astype(np.int64))
    if mesh.normals is not None:
        made.point_data["Normals"] = mesh.normals
        made.point_data.active_normals_name = "Normals"
    if mesh.colours is not None:
        made.point_data["RGB"] = _bytes(mesh.colours)
    if mesh.uvs is not None:
        made.active_texture_coordinates = mesh.uvs
    return made


def _bytes(colours: Any) -> Any:
    """0..1 as 0..255, (n, 3) uint8; None of none."""
    if colours is None:
        return None
    return np.round(np.clip(colours, 0, 1) * 255).astype(np.uint8)
