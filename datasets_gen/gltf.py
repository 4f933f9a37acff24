"""glTF and GLB files through trimesh: scenes are joined, what is written is one mesh."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.exchange.gltf import export_glb, export_gltf
from trimesh.visual import ColorVisuals, TextureVisuals

from lodbench.datasets_gen.surfaces import TriangleMesh

_EMPTY_GLTF = b'{"asset": {"version": "2.0"}}'


def parse_gltf(path: Path, data: bytes) -> TriangleMesh:
    """The meshes of the scene in a file, `data` its bytes, moved to their places and joined."""
    if path.suffix.lower() == ".glb":
        declared = int.from_bytes(data[8:12], "little")
        if data[:4] != b"glTF":
            raise ValueError("expected a GLB file, got no 'glTF' at its start")
        if declared > len(data):
            raise ValueError(f"truncated: expected {declared} bytes, got {len(data)}")
    return _joined(read_scene(path))


def read_scene(path: Path) -> trimesh.Scene:
    """What trimesh reads, as it is in the file: nothing merged or removed."""
    try:
        # texture coordinates come with the materials
        return trimesh.load_scene(str(path), process=False)
    except Exception:  # a missing or broken image is no reason to refuse the mesh
        return trimesh.load_scene(str(path), process=False, skip_materials=True)


def _joined(scene: trimesh.Scene) -> TriangleMesh:
    """All meshes of a scene where its graph puts them; attributes only where every mesh has them."""
    meshes: list[TriangleMesh] = []
    for node in scene.graph.nodes_geometry:
        transform, name = scene.graph[node]
        shape = scene.geometry[name]
        matrix = np.asarray(transform, np.float64)
        points = np.asarray(getattr(shape, "vertices", np.zeros((0, 3))), np.float64)
        points = points @ matrix[:3, :3].T + matrix[:3, 3]
        if not isinstance(shape, trimesh.Trimesh):
            if isinstance(shape, trimesh.PointCloud):
                meshes.append(TriangleMesh(points, np.zeros((0, 3), np.uint32)))
            continue
        triangles = np.asarray(shape.faces)
        mirrored = np.linalg.det(matrix[:3, :3]) < 0
        meshes.append(
            TriangleMesh(
                points,
                triangles[:, ::-1] if mirrored else triangles,
                _normals(shape, matrix),
                getattr(shape.visual, "uv", None),
                _colours(shape),
            )
        )
    if not meshes:
        return TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), np.uint32))
    start = np.cumsum([0] + [m.vertex_count for m in meshes])
    triangles = [m.triangles.astype(np.int64) + s for m, s in zip(meshes, start, strict=False)]

    def all_of(values: list) -> NDArray | None:
        return None if any(v is None for v in values) else np.concatenate(values)

    return TriangleMesh(
        np.concatenate([m.positions for m in meshes]),
        np.concatenate(triangles),
        all_of([m.normals for m in meshes]),
        all_of([m.uvs for m in meshes]),
        all_of([m.colours for m in meshes]),
    )


def _normals(shape: trimesh.Trimesh, matrix: NDArray[np.float64]) -> NDArray | None:
    # the property would compute them where the file has none
    given = shape._cache.cache.get("vertex_normals")
    if given is None or len(given) != len(shape.vertices):
        return None
    turned = np.asarray(given, np.float64) @ np.linalg.pinv(matrix[:3, :3])
    length = np.linalg.norm(turned, axis=1, keepdims=True)
    return np.where(length > 0, turned / np.where(length > 0, length, 1), (0.0, 0.0, 1.0))


def _colours(shape: trimesh.Trimesh) -> NDArray | None:
    if not isinstance(shape.visual, ColorVisuals) or shape.visual.kind != "vertex":
        return None
    return np.asarray(shape.visual.vertex_colors)[:, :3] / 255.0


def _gltf_scene(mesh: TriangleMesh) -> trimesh.Scene:
    shape = trimesh.Trimesh(
        mesh.positions, mesh.triangles, vertex_normals=mesh.normals, process=False
    )
    if mesh.uvs is not None:
        shape.visual = TextureVisuals(uv=mesh.uvs)
    elif mesh.colours is not None:
        colours = np.rint(np.clip(mesh.colours, 0, 1) * 255).astype(np.uint8)
        shape.visual = ColorVisuals(shape, vertex_colors=colours)
    return trimesh.Scene(shape)


def glb_parts(mesh: TriangleMesh) -> list[bytes]:
    """A GLB file of `mesh`, in parts."""
    if not mesh.triangle_count:
        text = _EMPTY_GLTF + b" " * (-len(_EMPTY_GLTF) % 4)
        sizes = (2, 20 + len(text), len(text))
        head = b"glTF" + b"".join(n.to_bytes(4, "little") for n in sizes) + b"JSON"
        return [head, text]
    return [export_glb(_gltf_scene(mesh))]


def gltf_parts(mesh: TriangleMesh) -> list[bytes]:
    """A glTF file of `mesh`, its arrays inside the text."""
    if not mesh.triangle_count:
        return [_EMPTY_GLTF]
    files = export_gltf(_gltf_scene(mesh), embed_buffers=True)
    return [files["model.gltf"]]
