"""Texture coordinates along a refined surface: what goes up of each corner, and which way they rise in space."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import Floats, TriangleMesh

ATTRIBUTES = 8  # u v, and the gradients of both
LARGEST = 1e6  # of a coordinate: beyond, floats have few fractions
STEEPEST = 1e6  # gradient per diagonal that counts


def uv_gradients(mesh: TriangleMesh) -> NDArray[np.float64]:
    """How u and v rise at each vertex, (n, 2, 3) float64, 1 / (largest extent of the box): see `uv_attributes`.

    A triangle has one gradient of each, in its plane; a vertex has the mean of its triangles', weighted by area, and
    zero where these have no area. Source: none; a reconstruction.
    """
    uvs = np.asarray(mesh.uvs, np.float64)
    low, high = mesh.box
    extent = max(float((high - low).max()), float(np.finfo(np.float32).tiny))
    a, b, c = ((mesh.positions.astype(np.float64) - low) / extent)[mesh.triangles].swapaxes(0, 1)
    facet = np.cross(b - a, c - a)
    double_area = np.linalg.norm(facet, axis=1)
    normal = facet / np.where(double_area > 0, double_area, 1)[:, None]
    rises = uvs[mesh.triangles[:, 1:]] - uvs[mesh.triangles[:, :1]]  # (m, 2 edges, u v)
    across = np.stack([np.cross(c - a, normal), np.cross(normal, b - a)], axis=1)
    sums = np.einsum("meu,mex->mux", rises, across)  # gradients times twice the area
    corners = mesh.triangles.ravel()
    area = np.bincount(corners, np.repeat(double_area, 3), mesh.vertex_count)
    flat = sums.reshape(-1, 6)
    total = np.stack(
        [np.bincount(corners, np.repeat(column, 3), mesh.vertex_count) for column in flat.T], axis=1
    )
    return (total / np.where(area > 0, area, 1)[:, None]).reshape(-1, 2, 3)


def uv_attributes(mesh: TriangleMesh, unit: float) -> Floats:
    """Of each triangle's corners u, v, the gradient of u and that of v, (m, 3, 8) float32.

    Gradients are per `unit`, model units, and at most `STEEPEST` along each axis.

    Raises:
        ValueError: texture coordinates that leave no digits for a place within a texture.
    """
    uvs = np.asarray(mesh.uvs, np.float32)
    if (size := float(np.abs(uvs).max(initial=0))) > LARGEST:
        raise ValueError(f"uvs: expected coordinates up to {LARGEST:g}, got {size:g}")
    low, high = mesh.box
    extent = max(float((high - low).max()), float(np.finfo(np.float32).tiny))
    gradients = np.clip(uv_gradients(mesh) * (unit / extent), -STEEPEST, STEEPEST)
    of_vertices = np.concatenate([uvs, gradients.reshape(-1, 6)], axis=1, dtype=np.float32)
    return of_vertices[mesh.triangles] + np.float32(0)  # zeros lose their sign
