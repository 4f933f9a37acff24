"""Which method for which mesh, and why."""

from __future__ import annotations

import inspect
from collections.abc import Collection
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.cluster import edge_collapse, hybrid, octree, quadric_clustering
from lodbench.kernels.parameters import closest
from lodbench.kernels.system import System

LARGE = 200_000  # triangles, from which on edge collapse of all takes long
MUCH = 0.3  # share of vertices that lie flat, from which on grids lose what is sharp
EVEN = 1e-6  # share by which the sum of a vertex's normals may be shorter than they are: flat, to 0.1 degrees
SAMPLED = 2048  # vertices that are looked at, about

EDGES, BOTH, GRID, TREE = (s.SYSTEM for s in (edge_collapse, hybrid, quadric_clustering, octree))


@dataclass(frozen=True)
class Choice:
    """A method, and the reason in one word.

    `why`: "cells" (of a grid were asked for), "options" (that no other takes), "small" (of triangles), "near" (the
    target to the mesh), "flat" (much of it), "large" (of triangles).
    """

    system: System[Any]
    why: str


def choose(mesh: TriangleMesh, target: int, names: Collection[str] = ()) -> Choice:
    """The method for a mesh.

    Args:
        mesh: what is simplified.
        target: triangles that are to be left.
        names: of all options that were given.

    Raises:
        TypeError: no method takes all of them.
    """
    if "cells" in names:
        return Choice(GRID, "cells")
    able = [system for system in (EDGES, BOTH, GRID, TREE) if takes(system) >= set(names)]
    if not able:
        known = set().union(*map(takes, (EDGES, BOTH, GRID, TREE)))
        if unknown := sorted(set(names) - known):
            raise TypeError(closest("option", unknown[0], known))
        raise TypeError(
            f"method: expected one to be named that takes {', '.join(sorted(names))}, got none"
        )
    if EDGES not in able or BOTH not in able:
        return Choice(able[0], "options")
    if mesh.triangle_count <= LARGE:
        return Choice(EDGES, "small")
    count = mesh.triangle_count
    if hybrid.Params(target_count=max(target, 1)).coarse(count) >= count:
        return Choice(EDGES, "near")
    if flat_share(mesh) > MUCH:
        return Choice(EDGES, "flat")
    return Choice(BOTH, "large")


def takes(system: System[Any]) -> set[str]:
    """Names of the options of a system's Params and of its verb."""
    params = type(next(iter(system.cases.values())))
    given = inspect.signature(system.verbs["simplify"]).parameters.values()
    own = {one.name for one in given if one.kind is inspect.Parameter.KEYWORD_ONLY}
    return own | {field.name for field in fields(params)}


def flat_share(mesh: TriangleMesh) -> float:
    """The share of vertices whose triangles lie in one plane, of an even choice of them; `reference` says it slowly."""
    step = 1 << max((mesh.vertex_count // SAMPLED).bit_length() - 1, 0)
    asked = mesh.triangles & np.uint32(step - 1) == 0
    rows = np.flatnonzero(asked[:, 0] | asked[:, 1] | asked[:, 2])
    corners = mesh.triangles[rows]
    a, b, c = (mesh.positions[corners[:, k]].astype(np.float64) for k in range(3))
    normals = np.cross(b - a, c - a)
    row, corner = np.nonzero(asked[rows])
    vertex, count = corners[row, corner] // np.uint32(step), mesh.vertex_count // step + 1
    sums = [np.bincount(vertex, normals[row, axis], count) for axis in range(3)]
    areas = np.bincount(vertex, np.linalg.norm(normals[row], axis=1), count)
    met = areas > 0
    long = np.linalg.norm(sums, axis=0)[met] >= (1 - EVEN) * areas[met]
    return float(long.mean()) if len(long) else 0.0
