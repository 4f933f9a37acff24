"""What glTF and GLB hold at vertices beside points and colours, past trimesh: it keeps texture coordinates only beside
a material, and turns normals as if they were points.

Both go through it as attributes of the application's own, whose names begin with an underscore.
"""

from __future__ import annotations

import contextlib
import json
import struct
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from lodbench.datasets_gen.arrays import usable

_OWN = {"NORMAL": "_LODBENCH_NORMAL", "TEXCOORD_0": "_LODBENCH_UV"}
_JSON = b"JSON"
UV = _OWN["TEXCOORD_0"]


def _primitives(document: Mapping[str, Any]) -> list[dict[str, Any]]:
    return [part for mesh in document["meshes"] for part in mesh["primitives"]]


def marked(data: bytes) -> bytes:
    """The file with its normals and texture coordinates under names of our own too; as it is where it is broken."""
    with contextlib.suppress(ValueError, LookupError, TypeError, AttributeError):
        text, rest = data, None
        if data[:4] == b"glTF":
            size = int.from_bytes(data[12:16], "little")
            if data[16:20] != _JSON or 20 + size > len(data):
                return data
            text, rest = data[20 : 20 + size].rstrip(b"\0"), data[20 + size :]
        document = json.loads(text)
        for part in _primitives(document):
            if "KHR_draco_mesh_compression" in part.get("extensions", {}):
                continue
            given = part["attributes"]
            given |= {own: given[name] for name, own in _OWN.items() if name in given}
        text = json.dumps(document, separators=(",", ":")).encode()
        if rest is None:
            return text
        text += b" " * (-len(text) % 4)
        head = struct.pack("<III", 0x46546C67, 2, 20 + len(text) + len(rest))
        return head + struct.pack("<I", len(text)) + _JSON + text + rest
    return data


def unmarked(document: dict[str, Any]) -> None:
    """A document that trimesh has made, its texture coordinates under their real name."""
    for part in _primitives(document) if "meshes" in document else ():
        if UV in part["attributes"]:
            part["attributes"]["TEXCOORD_0"] = part["attributes"].pop(UV)


def turned_over(uvs: NDArray[np.floating]) -> NDArray[np.float32]:
    """Texture coordinates of glTF, whose v grows downwards, as others have them; and back."""
    return np.stack([uvs[:, 0], 1 - uvs[:, 1]], axis=1).astype(np.float32)


def _uvs(shape: trimesh.Trimesh, to_world: NDArray[np.float64]) -> NDArray[np.floating] | None:
    found = shape.vertex_attributes.get(UV)
    if found is None:
        return None
    found = np.asarray(found)
    if found.dtype.kind in "iu":  # of the format's whole numbers the largest is 1
        found = found / np.iinfo(found.dtype).max
    found = usable(found, len(shape.vertices), 2)
    return None if found is None else turned_over(found)


def _normals(shape: trimesh.Trimesh, to_world: NDArray[np.float64]) -> NDArray[np.floating] | None:
    found = usable(shape.vertex_attributes.get(_OWN["NORMAL"]), len(shape.vertices), 3)
    if found is None:
        return None
    turn = to_world[:3, :3]
    if np.array_equal(turn, np.eye(3)):
        return found
    # cofactors: the inverse's transpose but for a factor, and defined where it is not
    cofactors = np.cross(turn[[1, 2, 0]], turn[[2, 0, 1]]) * (np.sign(np.linalg.det(turn)) or 1)
    found = found @ cofactors.T
    length = np.linalg.norm(found, axis=1, keepdims=True)
    return np.where(length > 0, found / np.where(length > 0, length, 1), (0.0, 0.0, 1.0))


def attributes(scene: trimesh.Scene, shapes: list[trimesh.Trimesh]) -> dict[str, NDArray]:
    """Normals and texture coordinates of the vertices of all `shapes` that a `marked` file's scene dumped.

    One that some shape lacks, or that is not finite, is left out.
    """
    getters: dict[str, Callable] = {"normals": _normals, "uvs": _uvs}
    result = {}
    for name, get in getters.items():
        found = [get(shape, scene.graph[shape.metadata["node"]][0]) for shape in shapes]
        if found and all(values is not None for values in found):
            result[name] = np.concatenate(found)
    return result
