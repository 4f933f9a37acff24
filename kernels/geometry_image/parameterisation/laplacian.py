"""Spherical parameterisations by sparse solves, for comparison: curvature flow, the centre rays, and their repair."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array, csr_array, diags_array
from scipy.sparse.linalg import splu
from scipy.spatial import KDTree

from lodbench.kernels.geometry_image.parameterisation.accept import flipped
from lodbench.kernels.geometry_image.parameterisation.hierarchy import Faces, Points

FLOW_STEPS, FLOW_TIME = 40, 2e-3
LARGEST_COTANGENT = 1e3
REPAIR_ROUNDS, RELAXATIONS = 40, 50

Progress = Callable[[float], None]


def _unit(vectors: Points) -> Points:
    length = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    return vectors / np.where(length > 0, length, 1)[:, None]


def _areas(positions: Points, faces: Faces) -> NDArray[np.float64]:
    a, b, c = (positions[faces[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def _centroid(positions: Points, faces: Faces) -> NDArray[np.float64]:
    area = _areas(positions, faces)
    return (positions[faces].mean(axis=1) * area[:, None]).sum(0) / area.sum()


def adjacency(faces: Faces, n: int) -> csr_array:
    """1 where two vertices share an edge of a closed mesh."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    return csr_array(coo_array((np.ones(len(start)), (start, end)), shape=(n, n)))


def _cotangent_stiffness(positions: Points, faces: Faces) -> csc_array:
    n = len(positions)
    rows, columns, values = [], [], []
    for k in range(3):
        i, j, o = faces[:, k], faces[:, (k + 1) % 3], faces[:, (k + 2) % 3]
        p, q = positions[i] - positions[o], positions[j] - positions[o]
        sine = np.linalg.norm(np.cross(p, q), axis=1)
        cotangent = np.einsum("ij,ij->i", p, q) / np.maximum(sine, 1e-300)
        half = np.clip(cotangent, -LARGEST_COTANGENT, LARGEST_COTANGENT) / 2
        rows += [i, j, i, j]
        columns += [j, i, i, j]
        values += [-half, -half, half, half]
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return csc_array(coo_array(entries, shape=(n, n)))


def _solver(matrix: csc_array):
    return splu(matrix, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})


def curvature_flow(positions: Points, faces: Faces, progress: Progress | None = None) -> Points:
    """The surface after conformalised mean curvature flow, projected to the sphere; ears become tiny, some turn over.

    Source: Kazhdan, Solomon & Ben-Chen 2012.
    """
    x = positions / np.sqrt(_areas(positions, faces).sum())
    stiffness = _cotangent_stiffness(x, faces)
    for step in range(FLOW_STEPS):
        mass = np.bincount(faces.ravel(), np.repeat(_areas(x, faces) / 3, 3), len(x))
        matrix = csc_array(diags_array(mass) + FLOW_TIME * stiffness)
        x = _solver(matrix).solve(mass[:, None] * x)
        x -= _centroid(x, faces)
        x /= np.sqrt(_areas(x, faces).sum())
        if progress is not None:
            progress((step + 1) / FLOW_STEPS)
    return _unit(x)


def repair(sphere: Points, faces: Faces, free: NDArray[np.bool_]) -> tuple[Points, int]:
    """Turned-over triangles untangled by convex combinations of what lies around them, in growing neighbourhoods.

    Args:
        sphere: (n, 3) float64, unit length.
        faces: (m, 3) int64.
        free: (n,) vertices that are to be solved for from the start; others join where triangles are turned over.

    Returns:
        The sphere, repaired as far as it went, and how many rounds that took.

    Source: Tutte 1963 (uniform weights); the growing of the free set is a reconstruction.
    """
    graph = adjacency(faces, len(sphere))
    average = csr_array(diags_array(1 / np.asarray(graph.sum(axis=1)).ravel()) @ graph)
    free = free.copy()
    for rounds in range(REPAIR_ROUNDS + 1):
        bad = flipped(sphere, faces)
        if rounds == REPAIR_ROUNDS or (not len(bad) and (rounds or not free.any())):
            return sphere, rounds
        near = np.zeros(len(sphere), bool)
        near[faces[bad]] = True
        for _ in range(2 if rounds else 1):
            near |= graph @ near > 0
        free |= near
        if free.all():
            return sphere, rounds
        inside = csc_array(average[free][:, free])
        outside = average[free][:, ~free] @ sphere[~free]
        identity = diags_array(np.ones(int(free.sum())))
        sphere = sphere.copy()
        sphere[free] = _unit(splu(csc_array(identity - inside)).solve(outside))
        for _ in range(RELAXATIONS):
            sphere[free] = _unit(inside @ sphere[free] + average[free][:, ~free] @ sphere[~free])
    return sphere, REPAIR_ROUNDS


def centre_rays(positions: Points, faces: Faces) -> tuple[Points, NDArray[np.bool_]]:
    """Each vertex seen from the centroid, and which vertices' rays meet the surface elsewhere too.

    Returns:
        Directions (n, 3) float64, and (n,) True where the position is to be solved for: the ray from the centroid
        through the vertex hits a triangle that the vertex is no corner of, or a triangle at the vertex faces inward.

    Source: Wang et al., section 2.
    """
    sphere = _unit(positions - _centroid(positions, faces))
    hidden = np.zeros(len(positions), bool)
    hidden[faces[flipped(sphere, faces)]] = True
    a, b, c = (sphere[faces[:, k]] for k in range(3))
    middle = _unit(a + b + c)
    reach = np.sqrt(np.maximum.reduce([((p - middle) ** 2).sum(1) for p in (a, b, c)]))
    tree = KDTree(sphere)
    normals = [np.cross(p, q) for p, q in ((b, c), (c, a), (a, b))]
    turned = np.sign(np.einsum("ij,ij->i", a, normals[0]))
    for first in range(0, len(faces), 20_000):
        part = slice(first, first + 20_000)
        found = tree.query_ball_point(middle[part], reach[part] * (1 + 1e-12))
        counts = np.fromiter((len(f) for f in found), np.int64, len(found))
        vertex = np.concatenate([np.asarray(f, np.int64) for f in found])
        face = first + np.repeat(np.arange(len(found)), counts)
        other = (faces[face] != vertex[:, None]).all(axis=1)
        vertex, face = vertex[other], face[other]
        inside = np.ones(len(vertex), bool)
        for normal in normals:
            inside &= np.einsum("ij,ij->i", sphere[vertex], normal[face]) * turned[face] >= 0
        hidden[vertex[inside]] = True
    return sphere, hidden
