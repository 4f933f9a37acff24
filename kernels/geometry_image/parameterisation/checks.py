"""Is this mesh one closed surface of genus 0? What is refused is named."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from lodbench.datasets_gen.arrays import box
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.opencl import Unsupported

Points = NDArray[np.float64]
Faces = NDArray[np.int64]
SHOWN = 3  # edges named in a refusal


class NotSpherical(Unsupported, ValueError):
    """The mesh is not one closed, oriented surface of genus 0, so it cannot be laid out on a sphere."""


@dataclass(frozen=True)
class Topology:
    """What was counted. An edge is named by its two vertices; unused vertices are not counted."""

    vertices: int
    edges: int
    faces: int
    components: int
    open_edges: Faces
    nonmanifold_edges: Faces
    misoriented_edges: Faces
    split_vertices: int  # fans beyond the first around one vertex
    repeated_corners: int  # triangles that name a vertex twice

    @property
    def euler_number(self) -> int:
        return self.vertices - self.edges + self.faces

    @property
    def faults(self) -> list[str]:
        """What keeps the mesh from being one closed surface of genus 0, one phrase each; empty when nothing does."""
        found = []
        for edges, what in (
            (self.open_edges, "open"),
            (self.nonmanifold_edges, "non-manifold"),
            (self.misoriented_edges, "misoriented"),
        ):
            if len(edges):
                shown = ", ".join(f"{a}-{b}" for a, b in edges[:SHOWN].tolist())
                more = ", ..." if len(edges) > SHOWN else ""
                found.append(f"{len(edges)} {what} edge{'s'[: len(edges) > 1]} ({shown}{more})")
        for count, what in (
            (self.split_vertices, "vertex shared by separate fans"),
            (self.repeated_corners, "triangle naming a vertex twice"),
        ):
            if count:
                found.append(f"{count} x {what}")
        if self.components != 1:
            found.append(f"{self.components} components")
        if self.euler_number != 2:
            found.append(f"Euler number {self.euler_number}")
        return found


def topology(triangles: NDArray[np.integer]) -> Topology:
    """Edges, components and fans of an indexed mesh; (m, 3) integers."""
    faces = np.asarray(triangles, np.int64)
    repeated = (faces == np.roll(faces, 1, axis=1)).any(axis=1)
    kept = faces[~repeated]
    start, end = kept.ravel(), np.roll(kept, -1, axis=1).ravel()
    span = int(faces.max(initial=0)) + 1
    key = np.minimum(start, end) * span + np.maximum(start, end)
    edges, which, uses = np.unique(key, return_inverse=True, return_counts=True)
    upward = np.bincount(which, start < end, len(edges))
    pairs = np.stack([edges // span, edges % span], axis=1)
    used = np.unique(kept)
    graph = coo_array((np.ones(len(start)), (start, end)), shape=(span, span))
    labels = connected_components(graph, directed=False)[1][used]
    return Topology(
        vertices=len(used),
        edges=len(edges),
        faces=len(kept),
        components=len(np.unique(labels)),
        open_edges=pairs[uses == 1],
        nonmanifold_edges=pairs[uses > 2],
        misoriented_edges=pairs[(uses == 2) & (upward != 1)],
        split_vertices=_fans(which, kept) - len(used),
        repeated_corners=int(repeated.sum()),
    )


def _fans(edge_of: Faces, faces: Faces) -> int:
    """Fans of triangles around all vertices: corners of one vertex that are joined across edges."""
    corners = np.arange(faces.size).reshape(-1, 3)
    # half-edge k of a face runs from corner k to corner k + 1; faces on one edge join their corners at both its ends
    first, last = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    order = np.argsort(edge_of, kind="stable")
    same = edge_of[order][1:] == edge_of[order][:-1]
    one, other = order[:-1][same], order[1:][same]
    vertex = faces.ravel()
    straight = vertex[first[one]] == vertex[first[other]]
    rows = np.concatenate([first[one], last[one]])
    columns = np.concatenate(
        [
            np.where(straight, first[other], last[other]),
            np.where(straight, last[other], first[other]),
        ]
    )
    graph = coo_array((np.ones(len(rows)), (rows, columns)), shape=(faces.size, faces.size))
    return int(connected_components(graph, directed=False)[0])


def require_sphere(mesh: TriangleMesh) -> tuple[Points, Faces, NDArray[np.int64]]:
    """The mesh in float64, centred and scaled to area 4 pi, without unused vertices.

    Returns:
        positions (n, 3) float64, triangles (m, 3) int64, and which of the mesh's vertices were kept, (n,).

    Raises:
        NotSpherical: open, non-manifold or misoriented edges, several components, another genus, a triangle
            and its back alone, or no area.
    """
    found = topology(mesh.triangles)
    faults = found.faults if mesh.triangle_count else ["no triangles"]
    if found.vertices == 3 and not faults:
        faults = ["a triangle and its back, without volume"]
    if faults:
        what = "; ".join(faults)
        raise NotSpherical(
            f"faces: expected one closed, oriented surface of genus 0 (Euler number 2), got {what}"
        )
    used = np.unique(mesh.triangles).astype(np.int64)
    renamed = np.zeros(mesh.vertex_count, np.int64)
    renamed[used] = np.arange(len(used))
    triangles = renamed[mesh.triangles]
    positions = mesh.positions[used].astype(np.float64)
    low, high = box(positions)
    positions = (positions - low) / max(float((high - low).max()), np.finfo(np.float64).tiny)
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    total = float(area.sum())
    if total <= 0:
        raise NotSpherical("points: expected a surface with area, got area 0")
    centroid = ((a + b + c) / 3 * area[:, None]).sum(0) / total
    return (positions - centroid) * np.sqrt(4 * np.pi / total), triangles, used
