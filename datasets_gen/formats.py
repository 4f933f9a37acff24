"""Meshes as the bytes of a file, in each of the formats that are written."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.exchange.gltf import export_glb, export_gltf
from trimesh.exchange.stl import export_stl

from lodbench.datasets_gen import gltf
from lodbench.datasets_gen.ply import ply_file
from lodbench.datasets_gen.surfaces import TriangleMesh

LOD_EXTENSION = "MSFT_lod"


def _scene(*meshes: TriangleMesh, names: Sequence[str] = ()) -> trimesh.Scene:
    """A node for each mesh, in their order; its levels of detail are numbered where there are no names."""
    scene = trimesh.Scene()
    for number, mesh in enumerate(meshes):
        place = np.eye(4)  # in text, with all digits of a float64
        if mesh.origin is not None:
            place[:3, 3] = mesh.origin
        name = names[number] if names else f"level_{number}" if number else None
        scene.add_geometry(_shape(mesh), name, name, transform=place)
    return scene


def _shape(mesh: TriangleMesh) -> trimesh.Trimesh:
    colours = mesh.colours
    if colours is not None:
        colours = np.rint(np.clip(colours, 0, 1) * 255).astype(np.uint8)
    shape = trimesh.Trimesh(
        mesh.positions,
        mesh.triangles,
        vertex_normals=mesh.normals,
        vertex_colors=colours,
        process=False,
    )
    if mesh.uvs is not None:
        shape.vertex_attributes[gltf.UV] = gltf.turned_over(mesh.uvs)
    return shape


def _as_levels(tree: dict[str, Any]) -> None:
    """Of the nodes of a scene the first alone is drawn, the others are its lower levels of detail."""
    gltf.unmarked(tree)
    (scene,) = tree["scenes"]
    first, *lower = scene["nodes"]
    if lower:
        scene["nodes"] = [first]
        tree["nodes"][first]["extensions"] = {LOD_EXTENSION: {"ids": lower}}
        tree["extensionsUsed"] = [*tree.get("extensionsUsed", []), LOD_EXTENSION]


def _lines(form: str, rows: NDArray) -> str:
    """One line per row."""
    return (form + "\n") * len(rows) % tuple(rows.ravel().tolist())


def _digits(points: NDArray) -> str:
    """How a coordinate is written: so many digits keep every bit, the fixed decimals of trimesh do not."""
    return "%.9g" if points.dtype == np.float32 else "%.17g"


def _obj_file(mesh: TriangleMesh) -> bytes:
    points = mesh.points
    form = "v" + 3 * f" {_digits(points)}"
    if mesh.colours is not None:
        points = np.concatenate([points, mesh.colours], axis=1)
        form += " %.9g %.9g %.9g"
    text, corner = "# triangle mesh\n" + _lines(form, points), "%d"
    if mesh.uvs is not None:
        text += _lines("vt %.9g %.9g", mesh.uvs)
        corner += "/%d"
    if mesh.normals is not None:
        text += _lines("vn %.9g %.9g %.9g", mesh.normals)
        corner += "/%d" if mesh.uvs is not None else "//%d"
    numbers = np.repeat(mesh.triangles + 1, corner.count("%"), axis=1)
    return (text + _lines(f"f {corner} {corner} {corner}", numbers)).encode()


def _off_file(mesh: TriangleMesh) -> bytes:
    text = f"OFF\n{mesh.vertex_count} {mesh.triangle_count} 0\n"
    text += _lines(" ".join(3 * [_digits(mesh.points)]), mesh.points)
    return (text + _lines("3 %d %d %d", mesh.triangles)).encode()


def _stl_file(mesh: TriangleMesh) -> bytes:
    """Binary, which is float32; text where that would lose the shape."""
    points = mesh.points
    shape = trimesh.Trimesh(mesh.positions, mesh.triangles, process=False)
    if (points.astype(np.float32) == points).all():
        shape.vertices = points
        return export_stl(shape)
    corners = np.concatenate([shape.face_normals, points[mesh.triangles].reshape(-1, 9)], axis=1)
    vertices = 3 * "vertex %.17g %.17g %.17g\n"
    form = f"facet normal %.9g %.9g %.9g\nouter loop\n{vertices}endloop\nendfacet"
    return f"solid mesh\n{_lines(form, corners)}endsolid mesh\n".encode()


WRITERS: dict[str, Callable[[TriangleMesh], bytes]] = {
    ".ply": ply_file,
    ".obj": _obj_file,
    ".stl": _stl_file,
    ".off": _off_file,
    ".gltf": lambda mesh: export_gltf(
        _scene(mesh), embed_buffers=True, tree_postprocessor=gltf.unmarked
    )["model.gltf"],
    ".glb": lambda mesh: export_glb(_scene(mesh), tree_postprocessor=gltf.unmarked),
}
"""By suffix."""


def _chain(levels: Sequence[TriangleMesh]) -> trimesh.Scene:
    """Levels without triangles are left out, for glTF cannot hold them."""
    return _scene(*([level for level in levels if level.triangle_count] or levels[:1]))


CHAIN_WRITERS: dict[str, Callable[[Sequence[TriangleMesh]], bytes]] = {
    ".gltf": lambda levels: export_gltf(
        _chain(levels), embed_buffers=True, tree_postprocessor=_as_levels
    )["model.gltf"],
    ".glb": lambda levels: export_glb(_chain(levels), tree_postprocessor=_as_levels),
}
"""Levels of detail in one file, finest first: readers that do not know the extension MSFT_lod see the finest alone.

Source: Khronos glTF 2.0, vendor extension MSFT_lod.
"""


def _parts(parts: Mapping[str, TriangleMesh]) -> trimesh.Scene:
    """Parts without triangles are left out, for glTF cannot hold them."""
    kept = {name: mesh for name, mesh in parts.items() if mesh.triangle_count}
    return _scene(*kept.values(), names=tuple(kept))


PART_WRITERS: dict[str, Callable[[Mapping[str, TriangleMesh]], bytes]] = {
    ".gltf": lambda parts: export_gltf(
        _parts(parts), embed_buffers=True, tree_postprocessor=gltf.unmarked
    )["model.gltf"],
    ".glb": lambda parts: export_glb(_parts(parts), tree_postprocessor=gltf.unmarked),
}
"""Named parts in one file, a node each."""

CARRIED = {
    ".ply": ("normals", "uvs", "colours", "tags"),
    ".obj": ("normals", "uvs", "colours"),
    ".gltf": ("normals", "uvs", "colours"),
    ".glb": ("normals", "uvs", "colours"),
}
"""What each holds beside points and triangles; the others, nothing."""
